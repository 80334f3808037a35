#pragma once
/// Which combinations of unknown parameters linear equations can determine.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance::identification {

/// Columns below this part of the largest one of the same unit are those of axes that are parallel but for round-off; so
/// are efforts below this part of the largest one.
inline constexpr double negligible_column = 1e-9;

/// Base parameters: β = x_B + K x_R, where B are as many independent columns as there are and R the others.
/// Source: M. Gautier, Numerical calculation of the base inertial parameters of robots, J. Robotic Systems 8(4), 1991.
struct BaseCombinations {
  std::vector<int> base;  ///< B: columns that are independent of each other
  std::vector<int> rest;  ///< R: all others
  MatrixX factors;        ///< B × R: K, exact zeros where a column does not depend on another

  /// β for the values of all parameters.
  VectorX evaluate(const VectorX& x) const;
  Eigen::Index rank() const { return static_cast<Eigen::Index>(base.size()); }
};

/// Chooses columns by a rank-revealing QR decomposition of columns scaled to norm 1: those of the lowest group first,
/// within a group the one that the chosen ones explain least.
/// @param measured rows at the measured states, which decide as far as they go
/// @param random rows at random states, whose rank is that of the mechanism
/// @param groups per column: 0 is chosen first
BaseCombinations find_base_combinations(const MatrixX& measured, const MatrixX& random, const std::vector<int>& groups);

/// Independent combinations of parameters that occur in `rows` and that those of `base` do not determine: reduced rows,
/// each with one 1 that no other has.
/// @return combinations × parameters; parameters of the base do not occur
MatrixX find_missing_combinations(const MatrixX& rows, const BaseCombinations& base, const std::vector<int>& groups);

}  // namespace balance::identification
