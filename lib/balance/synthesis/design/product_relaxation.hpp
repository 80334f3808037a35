#pragma once
/// Proofs of impossibility that use what products of numbers owe each other: m · m c² = (m c)².

#include "balance/synthesis/conditions/infeasibility_certificate.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// A combination of conditions that is positive for all numbers within their bounds, although not for all values of their
/// products taken one by one. Fixed numbers count with their values.
/// Source: convex relaxation of products (McCormick 1976; squares by their tangents), Farkas' lemma.
/// @param in_numbers the features as polynomials of the numbers themselves
std::optional<InfeasibilityCertificate> certify_by_product_relaxation(const SolverContext& context,
                                                                      const Conditions& conditions,
                                                                      const SparsePolynomial& in_numbers);

}  // namespace balance::design
