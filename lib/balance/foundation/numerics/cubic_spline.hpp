#pragma once
/// A C² cubic spline of vectors over one parameter.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance {

/// What closes the equations at both ends.
enum class SplineEnd {
  natural,     ///< no second derivative: of all curves through the points the one that bends least
  not_a_knot,  ///< third derivative continuous one knot in from the ends: fourth order up to them, needs four knots
};

/// Immutable; evaluation allocates nothing.
class CubicSpline {
 public:
  /// @param knots increasing, n ≥ 2 (not-a-knot: n ≥ 4)
  /// @param values n×k, row i at knots[i]
  /// @throws std::invalid_argument if the sizes differ, knots are too few or do not increase
  CubicSpline(std::vector<double> knots, Samples values, SplineEnd end);

  /// Value, first and second derivative with respect to the parameter; each result has k entries already.
  /// Outside the knots the outermost cubic goes on.
  void at(double parameter, Eigen::Ref<VectorX> value, Eigen::Ref<VectorX> first, Eigen::Ref<VectorX> second) const;

  /// Length of the stretch between two knots that holds the parameter.
  double interval_length(double parameter) const;

  /// Where the third derivative may jump, and the ends.
  const std::vector<double>& knots() const { return knots_; }

  /// Number k of components.
  int size() const { return static_cast<int>(values_.cols()); }

 private:
  std::vector<double> knots_;
  Samples values_;   ///< n×k
  Samples moments_;  ///< n×k second derivatives at the knots
};

}  // namespace balance
