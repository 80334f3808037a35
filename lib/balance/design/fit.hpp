#pragma once
/// Polynomials through samples of a function whose variables fall into small groups. Private to design.

#include "balance/design/polynomial.hpp"
#include "balance/design/survey.hpp"

#include <functional>
#include <optional>

namespace balance::design {

/// Features as polynomials of degree four or less in unit coordinates, found from few samples and checked at others.
/// @return nothing if they are none, or if too many numbers act together
std::optional<SparsePolynomial> fit_feature_polynomials(const VariableClassification& survey,
                                                        const std::function<VectorX(const VectorX& u)>& features);

}  // namespace balance::design
