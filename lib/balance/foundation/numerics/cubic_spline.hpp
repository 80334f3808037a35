#pragma once
/// A C² vector-valued cubic spline of one parameter.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance::numerics {

/// End conditions.
enum class SplineEnd {
  natural,     ///< zero second derivative: minimum bending among all curves through the points
  not_a_knot,  ///< third derivative continuous one knot in from the ends: fourth order throughout; needs four knots
  periodic,    ///< closed: the last value equals the first, and both derivatives are continuous there; needs four knots
};

/// Second derivatives at the knots of the spline through the values, n×k. @pre as for CubicSpline
Samples find_spline_second_derivatives(const std::vector<double>& knots, const Samples& values, SplineEnd end);

/// Immutable; evaluation allocates nothing.
class CubicSpline {
 public:
  /// @param knots increasing, n ≥ 2 (not-a-knot and periodic: n ≥ 4)
  /// @param values n×k, row i at knots[i]
  /// @throws std::invalid_argument if the sizes differ, knots are too few or do not increase
  CubicSpline(std::vector<double> knots, Samples values, SplineEnd end);

  /// Value, first and second derivative with respect to the parameter. Outside the knots, extrapolates the outermost
  /// cubic.
  /// @pre each result has k entries
  void at(double parameter, Eigen::Ref<VectorX> value, Eigen::Ref<VectorX> first, Eigen::Ref<VectorX> second) const;

  /// Distance between the two knots that enclose the parameter.
  double interval_length(double parameter) const;

  /// The ends and the points where the third derivative may jump.
  const std::vector<double>& knots() const { return knots_; }

  /// Number k of components.
  int size() const { return static_cast<int>(values_.cols()); }

 private:
  std::vector<double> knots_;
  Samples values_;   ///< n×k
  Samples moments_;  ///< n×k second derivatives at the knots
};

}  // namespace balance::numerics
