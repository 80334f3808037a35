#pragma once
/// Feasible s'' for a path parameter and a rate.

#include "balance/motion/time_optimal/path_model.hpp"

#include <vector>

namespace balance::time_optimal {

/// Bounds of s'' and the rows that they come from (−1: none).
struct AccelerationInterval {
  double lower = 0, upper = 0;
  int lower_row = -1, upper_row = -1;

  bool is_empty() const { return !(lower <= upper); }
};

/// Upper bound of x and its row; infinite if there is none.
struct VelocityBound {
  double x = 0;
  int row = -1;
};

/// The limits at one path parameter. x is s'² throughout.
class AccelerationLimits {
 public:
  /// @param bounds one per row of the model, positive; both must outlive this
  AccelerationLimits(const PathModel& model, const std::vector<double>& bounds);

  /// Moves to a path parameter, with the series of the panels [first, last) extrapolated beyond their ends.
  void move_to(double s, std::size_t first_panel, std::size_t last_panel);
  /// Whether there were so many evaluations that the search must have failed.
  bool has_reached_evaluation_limit() const { return evaluations_ > max_evaluations; }

  /// Sets the a of every row that vanishes here to zero, until the next move_to(). @return whether there is one
  bool drop_zero_inertia_rows();
  bool is_dropped(int row) const { return row >= 0 && dropped_[static_cast<std::size_t>(row)] != 0; }

  AccelerationInterval bounds(double x) const;
  /// Bounds from the rows with a only, also beyond the velocity bound.
  AccelerationInterval bounds_by_acceleration_rows(double x) const;
  /// Bound of the rows without a.
  VelocityBound direct_velocity_bound() const;
  /// The largest x connected with rest for which the interval is not empty; with the row if that is one without a.
  /// @param guess initial guess; 0: none
  VelocityBound max_velocity(double guess = 0) const;

  // On the bound of a row where its a vanishes (docs/motion.md, section 3):
  double acceleration_on_bound(int row, double x) const;                  ///< s''
  double acceleration_slope_on_bound(int row, double x, double u) const;  ///< its derivative with respect to s
  double zero_inertia_slope(int row, double x) const;  ///< a' + 2b + d/s', projected on the row's value

  /// Magnitude of a row's value minus its centre.
  double magnitude(int row, double x, double u) const;
  /// Value of a scalar at rest.
  double static_value(int row) const { return value(model_.rows[static_cast<std::size_t>(row)].c, 0); }

 private:
  /// Coefficients of a row, or their derivatives, projected on its value where a is zero.
  struct ProjectedCoefficients {
    double a, b, c, d;
  };

  void apply_scalar_row(const PathConstraintRow& row, double bound, double x, double v, int index,
                        AccelerationInterval& interval) const;
  void apply_vector_row(const PathConstraintRow& row, double bound, double x, double v, int index,
                        AccelerationInterval& interval) const;
  double direct_velocity_bound_of(int row) const;
  double velocity_bound_of_scalar(const PathConstraintRow& row, double bound) const;
  ProjectedCoefficients project(const numerics::PiecewiseChebyshevSeries& series, int row, double x) const;
  double value(int column, int i) const { return column < 0 ? 0 : values_[column + i]; }
  /// Component of a row without s'', minus its centre.
  double value_without_acceleration(const PathConstraintRow& row, int i, double x, double v) const {
    return value(row.b, i) * x + value(row.c, i) + value(row.d, i) * v - row.centre;
  }
  bool is_velocity_row(int row) const;

  const PathModel& model_;
  const std::vector<double>& bounds_;
  static constexpr long max_evaluations = 2'000'000;
  long evaluations_ = 0;
  double s_ = 0;
  std::size_t panel_ = 0;
  VectorX values_;
  mutable VectorX scratch_;
  std::vector<char> dropped_;
};

}  // namespace balance::time_optimal
