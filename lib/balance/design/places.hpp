#pragma once
/// Points and directions by which a set of places is measured. Private to design.

#include "balance/base/types.hpp"

namespace balance::design {

/// Numbers that a grid is made for.
inline constexpr int max_grid_dimension = 2;
/// Points that fill the box −1…1 of n numbers, bounds included, as columns.
MatrixX grid_points(int n);

/// Unit vectors all around as rows, the axes among them.
/// @param dimension 2 or 3
MatrixX direction_samples(int dimension);

}  // namespace balance::design
