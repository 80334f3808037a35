#pragma once
/// Least weighted sums of maxima of smooth functions: figures with known slopes, peaks among them. Private to design.

#include "balance/design/context.hpp"
#include "balance/design/figure_of_merit.hpp"

namespace balance::design {

/// Down from a point, within the box and with physical bodies. Every maximum gets a bound of its own, which is made small in its place while
/// all functions that it is taken over are kept below (epigraph form): at a minimum several peaks are often equal, and the sum has a kink.
/// @param merit has pieces
/// @return the best admissible point that was met; nothing if `from` has no value
std::optional<VectorX> minimise_max_terms_from(const SolverContext& context, const ScaledObjective& merit,
                                               const VectorX& from);

/// From the best of some points that fill the box, and from `start`.
/// @return the ends, the best first; empty if there is no value anywhere
std::vector<VectorX> minimise_max_terms(const SolverContext& context, const ScaledObjective& merit,
                                        const VectorX& start);

}  // namespace balance::design
