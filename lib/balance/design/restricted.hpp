#pragma once
/// The same design problem with some of its numbers held. Private to design.

#include "balance/design/context.hpp"

namespace balance::designing {

/// Lengths and ratios stay as they are at x, the other numbers are free and start from there: conditions of one geometry, and an
/// objective that often is convex.
/// @param seconds that it may take
DesignProblem at_fixed_geometry(const Context& context, const VectorX& x, double seconds);

/// Positions of the numbers that do not change the geometry, and of those that do.
std::vector<int> inertial_numbers(const Context& context);
std::vector<int> geometric_numbers(const Context& context);

}  // namespace balance::designing
