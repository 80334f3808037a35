#pragma once
/// A path with the coefficients of limited quantities as functions of its parameter.

#include "balance/foundation/numerics/chebyshev_fit.hpp"
#include "balance/mechanics/results/limitable_quantities.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance::time_optimal {

constexpr double breakpoint_tolerance = 1e-9;  ///< of the parameter: points closer than this coincide

/// One limited quantity: the vector a s'' + b s'² + c + d s', whose magnitude is bounded. The bound of a scalar may be
/// about a centre other than zero.
struct PathConstraintRow {
  std::string name, unit;
  int count = 1;
  int a = -1, b = -1, c = -1, d = -1;  ///< first column of each in the series; −1: zero
  bool has_acceleration_term = true;   ///< false: a vanishes, and the row limits only the rate
  double centre = 0;                   ///< mean of a scalar's two limits
};

struct PathModel {
  MotionOutcome outcome;  ///< done, or why there is no model
  std::vector<PathConstraintRow> rows;
  numerics::PiecewiseChebyshevSeries value, first, second;  ///< the columns and their two derivatives with respect to s
  std::vector<double> segment_ends;                         ///< where the motion is at rest, including 0 and 1
  std::vector<double> breakpoints;          ///< leg ends, knots, jumps of friction, zeros of a row's a; increasing
  std::vector<double> zero_inertia_points;  ///< the breakpoints at which a row's a is zero
  double start_speed = 0, end_speed = 0;    ///< of the driven point at both ends for s' = 1
  VectorX max_magnitude;                    ///< maximum magnitude of each column on the path
};

/// @throws std::invalid_argument if the trajectory asks for something that does not exist
PathModel build_path_model(const Mechanism& mechanism, const Trajectory& trajectory,
                           const std::vector<results::LimitableQuantity>& quantities);

/// Zeros of one function of a series, by its sign changes; increasing.
std::vector<double> find_roots(const numerics::PiecewiseChebyshevSeries& series, Eigen::Index function);

// Coefficients of s'', s'², 1 and s' of the limited quantities at points of a path.

/// The path at constant speed in one second, so that time is the path parameter.
Trajectory reparametrise_by_path(Trajectory trajectory);

/// Columns of one quantity's coefficients in a row of samples: `count` columns each; −1: none.
struct CoefficientColumns {
  results::LimitableQuantity quantity;
  int a = -1, b = -1, c = -1, d = -1;  ///< of s'', s'², 1, s'
};

/// A path without a law, with parameter s from 0 to 1.
class PathDynamicsSampler {
 public:
  virtual ~PathDynamicsSampler() = default;

  /// Done, or why the path cannot be followed.
  const MotionOutcome& outcome() const { return outcome_; }
  const std::vector<CoefficientColumns>& limits() const { return limits_; }
  int columns() const { return columns_; }
  /// Where one leg ends at rest and the next begins, including 0 and 1.
  const std::vector<double>& leg_ends() const { return leg_ends_; }
  /// Knots of splines, at which accelerations have kinks.
  const std::vector<double>& knots() const { return knots_; }
  /// Number of components of the corridor's point. @throws std::invalid_argument if there are fewer than two
  int corridor_components() const { return trajectory::count_corridor_components(quantities_); }
  /// Speed of the driven point at both ends for s' = 1 [m]; without a point, the norm of the driven coordinates' rates.
  double start_speed() const { return start_speed_; }
  double end_speed() const { return end_speed_; }

  /// @param path_parameters increasing, in (0, 1), none of them the end of a leg
  /// @param rows one per path parameter, with the columns of limits()
  /// @return false if the path cannot be followed; outcome() says why
  virtual bool sample(const std::vector<double>& path_parameters, Samples& rows) = 0;

  /// Rates of the coordinates with dry friction for s' = 1. Friction jumps where they change sign.
  virtual bool sample_friction(const std::vector<double>& path_parameters, Samples& rows) = 0;
  virtual int friction_count() const = 0;

  /// Magnitude of joint reaction forces [N] and moments [N m] for s' = 1 and for s'' = 1, as the scale of round-off.
  struct ReactionMagnitude {
    double force = 0, moment = 0;
  };
  virtual ReactionMagnitude max_reactions(const std::vector<double>& path_parameters) = 0;

 protected:
  MotionOutcome outcome_;
  std::vector<CoefficientColumns> limits_;
  int columns_ = 0;
  std::vector<double> leg_ends_, knots_;
  trajectory::DriveQuantities quantities_;
  double start_speed_ = 0, end_speed_ = 0;
};

/// @param trajectory its law, duration and limits have no effect
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
std::unique_ptr<PathDynamicsSampler> make_path_dynamics_sampler(
    const Mechanism& mechanism, const Trajectory& trajectory,
    const std::vector<results::LimitableQuantity>& quantities);

// A limited quantity at a point of a motion along a path, with its derivatives.

/// A point of a motion along a path, and the row of interest.
struct PathPoint {
  double s = 0, v = 0, u = 0;  ///< s, s', s''
  int row = 0;
};

/// a u + b x + c + d√x with x = v², minus the centre.
struct ConstraintValue {
  VectorX value;  ///< all components
  double magnitude = 0;
  double d_du = 0, d_dx = 0;         ///< derivatives of the magnitude
  bool is_velocity_limited = false;  ///< a vanishes or is perpendicular to the value: u does not change the magnitude
};

ConstraintValue evaluate_constraint(const PathModel& model, const PathPoint& point);

// The limits of a trajectory as rows of a path model.

/// All limits as given, including several on one quantity.
struct PathLimits {
  std::vector<results::LimitableQuantity> quantities;
  std::vector<double> half_widths, centres;  ///< half of the difference of two limits, and their mean
};

/// The quantities that a name stands for. @throws std::invalid_argument if there are none
std::vector<results::LimitableQuantity> require_limited_quantities(const Mechanism& mechanism, const std::string& name);

/// @param what the law or path to be found: "the law 'fastest'"
/// @throws std::invalid_argument if a load depends on time, since a point of the path can be passed at any time
void require_constant_loads(const Mechanism& mechanism, const std::string& what);

/// @throws std::invalid_argument if limits are invalid, or loads depend on time. The message is suitable for users.
PathLimits collect_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// The path model whose first rows are the limits, each about its centre.
PathModel build_limited_path_model(const Mechanism& mechanism, const Trajectory& trajectory, const PathLimits& limits);

}  // namespace balance::time_optimal
