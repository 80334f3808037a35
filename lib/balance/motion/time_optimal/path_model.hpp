#pragma once
/// A path with what the limited quantities are on it, as functions of its parameter.

#include "balance/foundation/numerics/chebyshev_fit.hpp"
#include "balance/mechanics/results/limitable_quantities.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance {

constexpr double breakpoint_tolerance = 1e-9;  ///< of the parameter: places nearer to each other than this are one

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

// What the limited quantities are at the places of a path: coefficients of s'', s'², 1 and s'.

/// The path alone, run through in one second: time is the path's parameter.
Trajectory reparametrise_by_path(Trajectory trajectory);

/// Where one quantity's coefficients stand in a row of samples: `count` columns each; −1: it has none.
struct CoefficientColumns {
  LimitableQuantity quantity;
  int a = -1, b = -1, c = -1, d = -1;  ///< of s'', s'², 1, s'
};

/// A path without a law: its parameter s runs from 0 to 1.
class PathDynamicsSampler {
 public:
  virtual ~PathDynamicsSampler() = default;

  /// Done, or why the path cannot be followed.
  const MotionOutcome& outcome() const { return outcome_; }
  const std::vector<CoefficientColumns>& limits() const { return limits_; }
  int columns() const { return columns_; }
  /// Where one leg ends in rest and the next begins, 0 and 1 included.
  const std::vector<double>& leg_ends() const { return leg_ends_; }
  /// Where splines have knots: accelerations bend there.
  const std::vector<double>& knots() const { return knots_; }
  /// How many components the point has that a corridor is for. @throws std::invalid_argument if it has fewer than two
  int corridor_components() const { return balance::count_corridor_components(quantities_); }
  /// How fast the driven point goes at both ends for s' = 1 [m]; without one the norm of the driven coordinates' rates.
  double start_speed() const { return start_speed_; }
  double end_speed() const { return end_speed_; }

  /// @param places increasing, in (0, 1), none of them the end of a leg
  /// @param rows one per place: the columns that limits() names
  /// @return false if the path cannot be followed; outcome() says why
  virtual bool sample(const std::vector<double>& places, Samples& rows) = 0;

  /// Rates of the coordinates with dry friction, for s' = 1: where they change their sign, friction jumps.
  virtual bool sample_friction(const std::vector<double>& places, Samples& rows) = 0;
  virtual int friction_count() const = 0;

  /// How large forces [N] and moments [N m] are that joints transmit for s' = 1 and for s'' = 1: what round-off is a part of.
  struct ReactionMagnitude {
    double force = 0, moment = 0;
  };
  virtual ReactionMagnitude max_reactions(const std::vector<double>& places) = 0;

 protected:
  MotionOutcome outcome_;
  std::vector<CoefficientColumns> limits_;
  int columns_ = 0;
  std::vector<double> leg_ends_, knots_;
  DriveQuantities quantities_;
  double start_speed_ = 0, end_speed_ = 0;
};

/// @param trajectory its law, duration and limits do not matter
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
std::unique_ptr<PathDynamicsSampler> make_path_dynamics_sampler(const Mechanism& mechanism,
                                                                const Trajectory& trajectory,
                                                                const std::vector<LimitableQuantity>& quantities);

// A limited quantity at a moment of a motion along a path, with its derivatives.

/// A moment on a path, and the row that matters there.
struct PathPoint {
  double s = 0, v = 0, u = 0;  ///< s, s', s''
  int row = 0;
};

/// a u + b x + c + d√x with x = v², less its middle.
struct ConstraintValue {
  VectorX value;  ///< of every component
  double magnitude = 0;
  double d_du = 0, d_dx = 0;  ///< derivatives of the magnitude
  bool is_velocity_limited =
      false;  ///< a vanishes, or is at right angles to the value: u does not change the magnitude
};

ConstraintValue evaluate_constraint(const PathModel& model, const PathPoint& moment);

// The limits that a trajectory states, as rows of a path.

/// Limits as given, several on one quantity all kept.
struct PathLimits {
  std::vector<LimitableQuantity> quantities;
  std::vector<double> half_widths, centres;  ///< half of the way between two limits, and what lies between them
};

/// What a name stands for. @throws std::invalid_argument if there is no such quantity
std::vector<LimitableQuantity> require_limited_quantities(const Mechanism& mechanism, const std::string& name);

/// @param what is searched for: "the law 'fastest'"
/// @throws std::invalid_argument if a load changes with time, so that what a place of the path needs depends on when
void require_constant_loads(const Mechanism& mechanism, const std::string& what);

/// @throws std::invalid_argument for limits that mean nothing, here or under the mechanism's loads. The message is fit for a user.
PathLimits collect_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// The path, its first rows those of the limits, each about its middle.
PathModel build_limited_path_model(const Mechanism& mechanism, const Trajectory& trajectory, const PathLimits& limits);

}  // namespace balance
