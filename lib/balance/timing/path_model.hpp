#pragma once
/// A path with what the limited quantities are on it, as functions of its parameter. Private to timing.

#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"
#include "balance/result/limited.hpp"
#include "balance/timing/series.hpp"

#include <string>
#include <vector>

namespace balance {

/// One limited quantity: the vector a s'' + b s'² + c + d s', whose magnitude has a bound. A scalar's bound may be about another
/// middle than zero.
struct PathConstraintRow {
  std::string name, unit;
  int count = 1;
  int a = -1, b = -1, c = -1, d = -1;  ///< first column of each in the series; −1: zero
  bool has_acceleration_term = true;   ///< false: a vanishes, it limits the speed alone
  double centre = 0;                   ///< of a scalar's two limits
};

struct PathModel {
  MotionOutcome outcome;  ///< done, or why there is none
  std::vector<PathConstraintRow> rows;
  PiecewiseChebyshevSeries value, first, second;  ///< the columns and their two derivatives with respect to s
  std::vector<double> segment_ends;               ///< where the motion rests, 0 and 1 included
  std::vector<double> breakpoints;  ///< leg ends, knots, jumps of friction, places where a row's a is zero, increasing
  std::vector<double> zero_inertia_points;  ///< those of them where a row's a is zero
  double start_speed = 0, end_speed = 0;    ///< of the driven point at both ends for s' = 1
  VectorX max_magnitude;                    ///< per column: its largest magnitude on the path
};

/// @throws std::invalid_argument if the trajectory asks for something that does not exist
PathModel build_path_model(const Mechanism& mechanism, const Trajectory& trajectory,
                           const std::vector<LimitableQuantity>& quantities);

/// Zeros of a function of a series between two parameters within one panel, increasing.
std::vector<double> find_roots(const PiecewiseChebyshevSeries& series, Eigen::Index function);

}  // namespace balance
