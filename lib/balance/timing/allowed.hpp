#pragma once
/// Which s'' the limits allow at a place of the path and a speed. Private to timing.

#include "balance/timing/path_model.hpp"

#include <vector>

namespace balance {

/// The path's second rate between two bounds, and which rows they are of (−1: none).
struct Interval {
  double low = 0, high = 0;
  int low_row = -1, high_row = -1;

  bool empty() const { return !(low <= high); }
};

/// How fast at most, and by which row. Infinite without one.
struct Ceiling {
  double x = 0;
  int row = -1;
};

/// The limits at one place. x is s'² throughout.
class Allowed {
 public:
  /// @param bounds one per row of the model, positive; both must outlive this
  Allowed(const PathModel& model, const std::vector<double>& bounds);

  /// Goes to a place, by the series of the panels [first, last), which go on beyond their ends.
  void go(double place, std::size_t first_panel, std::size_t last_panel);
  /// Whether so many places have been looked at that the search must have lost its way.
  bool exhausted() const { return looks_ > most_looks; }

  /// Takes the a of every row that has a zero there for zero, until the next go(). @return whether there is one
  bool drop_inertia();
  bool has_dropped(int row) const { return row >= 0 && dropped_[static_cast<std::size_t>(row)] != 0; }

  Interval at(double x) const;
  /// By the rows with an a alone: goes on beyond the cap.
  Interval by_inertia(double x) const;
  /// Where the rows without a end the speed.
  Ceiling cap() const;
  /// The largest x of the part, connected with rest, where the interval is not empty; the row if it is one without a.
  /// @param guess where to look first; 0: nowhere in particular
  Ceiling ceiling(double guess = 0) const;

  // Along the bound of a row where its a vanishes (docs/motion.md, section 3):
  double along(int row, double x) const;                 ///< s''
  double bend_along(int row, double x, double u) const;  ///< its derivative with respect to s
  double steepness(int row, double x) const;             ///< a' + 2b + d/s', seen along the row's value

  /// The magnitude of a row's value, less its middle.
  double magnitude(int row, double x, double u) const;
  /// A scalar's value at rest.
  double at_rest(int row) const { return value(model_.rows[static_cast<std::size_t>(row)].c, 0); }

 private:
  /// The coefficients of a row, or their derivatives, along the direction of its value where a is zero.
  struct Projected {
    double a, b, c, d;
  };

  void cut_scalar(const LimitRow& row, double bound, double x, double v, int index, Interval& interval) const;
  void cut_vector(const LimitRow& row, double bound, double x, double v, int index, Interval& interval) const;
  double cap_of(int row) const;
  double cap_of_scalar(const LimitRow& row, double bound) const;
  Projected project(const PiecewiseSeries& series, int row, double x) const;
  double value(int column, int i) const { return column < 0 ? 0 : values_[column + i]; }
  /// What a row's component is without s'', less its middle.
  double without_inertia(const LimitRow& row, int i, double x, double v) const {
    return value(row.b, i) * x + value(row.c, i) + value(row.d, i) * v - row.middle;
  }
  bool without_a(int row) const;

  const PathModel& model_;
  const std::vector<double>& bounds_;
  static constexpr long most_looks = 2'000'000;
  long looks_ = 0;
  double place_ = 0;
  std::size_t panel_ = 0;
  VectorX values_;
  mutable VectorX scratch_;
  std::vector<char> dropped_;
};

}  // namespace balance
