#pragma once
/// Which s'' the limits allow at a place of the path and a speed.

#include "balance/motion/time_optimal/path_model.hpp"

#include <vector>

namespace balance {

/// The path's second rate between two bounds, and which rows they are of (−1: none).
struct AccelerationInterval {
  double lower = 0, upper = 0;
  int lower_row = -1, upper_row = -1;

  bool is_empty() const { return !(lower <= upper); }
};

/// How fast at most, and by which row. Infinite without one.
struct VelocityBound {
  double x = 0;
  int row = -1;
};

/// The limits at one place. x is s'² throughout.
class AccelerationLimits {
 public:
  /// @param bounds one per row of the model, positive; both must outlive this
  AccelerationLimits(const PathModel& model, const std::vector<double>& bounds);

  /// Goes to a place, by the series of the panels [first, last), which go on beyond their ends.
  void move_to(double place, std::size_t first_panel, std::size_t last_panel);
  /// Whether so many places have been looked at that the search must have lost its way.
  bool has_reached_evaluation_limit() const { return evaluations_ > max_evaluations; }

  /// Takes the a of every row that has a zero there for zero, until the next go(). @return whether there is one
  bool drop_zero_inertia_rows();
  bool is_dropped(int row) const { return row >= 0 && dropped_[static_cast<std::size_t>(row)] != 0; }

  AccelerationInterval bounds(double x) const;
  /// By the rows with an a alone: goes on beyond the cap.
  AccelerationInterval bounds_by_acceleration_rows(double x) const;
  /// Where the rows without a end the speed.
  VelocityBound direct_velocity_bound() const;
  /// The largest x of the part, connected with rest, where the interval is not empty; the row if it is one without a.
  /// @param guess where to look first; 0: nowhere in particular
  VelocityBound max_velocity(double guess = 0) const;

  // Along the bound of a row where its a vanishes (docs/motion.md, section 3):
  double acceleration_on_bound(int row, double x) const;                  ///< s''
  double acceleration_slope_on_bound(int row, double x, double u) const;  ///< its derivative with respect to s
  double zero_inertia_slope(int row, double x) const;  ///< a' + 2b + d/s', seen along the row's value

  /// The magnitude of a row's value, less its middle.
  double magnitude(int row, double x, double u) const;
  /// A scalar's value at rest.
  double static_value(int row) const { return value(model_.rows[static_cast<std::size_t>(row)].c, 0); }

 private:
  /// The coefficients of a row, or their derivatives, along the direction of its value where a is zero.
  struct ProjectedCoefficients {
    double a, b, c, d;
  };

  void apply_scalar_row(const PathConstraintRow& row, double bound, double x, double v, int index,
                        AccelerationInterval& interval) const;
  void apply_vector_row(const PathConstraintRow& row, double bound, double x, double v, int index,
                        AccelerationInterval& interval) const;
  double direct_velocity_bound_of(int row) const;
  double cap_of_scalar(const PathConstraintRow& row, double bound) const;
  ProjectedCoefficients project(const PiecewiseChebyshevSeries& series, int row, double x) const;
  double value(int column, int i) const { return column < 0 ? 0 : values_[column + i]; }
  /// What a row's component is without s'', less its middle.
  double value_without_acceleration(const PathConstraintRow& row, int i, double x, double v) const {
    return value(row.b, i) * x + value(row.c, i) + value(row.d, i) * v - row.centre;
  }
  bool is_velocity_row(int row) const;

  const PathModel& model_;
  const std::vector<double>& bounds_;
  static constexpr long max_evaluations = 2'000'000;
  long evaluations_ = 0;
  double place_ = 0;
  std::size_t panel_ = 0;
  VectorX values_;
  mutable VectorX scratch_;
  std::vector<char> dropped_;
};

}  // namespace balance
