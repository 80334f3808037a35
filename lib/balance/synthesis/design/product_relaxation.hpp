#pragma once
/// Infeasibility proofs that use relations between products: m · m c² = (m c)².

#include "balance/synthesis/conditions/infeasibility_certificate.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// Finds a combination of conditions that is positive for all values of the variables within their bounds, although not
/// for independent values of their products. Fixed variables enter with their values.
/// Source: convex relaxation of products (McCormick 1976; tangents of squares), Farkas' lemma.
/// @param in_numbers the features as polynomials of the variables [SI]
std::optional<conditions::InfeasibilityCertificate> certify_by_product_relaxation(
    const SolverContext& context, const Conditions& conditions, const numerics::SparsePolynomial& in_numbers);

}  // namespace balance::design
