#pragma once
/// Offsets from a path within its corridor: perpendicular to the path, as cubic splines of the path parameter.

#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/mechanics/trajectory/geometric_path.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>
#include <string>

namespace balance::trajectory {

// Offsets of driven quantities from their path, as functions of one parameter.

/// Value of an offset and its first and second derivative with respect to its parameter.
struct ValueWithDerivatives {
  double value = 0, first = 0, second = 0;
};

/// @param series three functions on [0, 1]: value, first and second derivative
/// @param side one-sided limit to take where the second derivative jumps
ValueWithDerivatives evaluate_with_derivatives(const numerics::PiecewiseChebyshevSeries& series, double parameter,
                                               Side side);

/// The function and its first two derivatives.
numerics::PiecewiseChebyshevSeries append_derivatives(const numerics::PiecewiseChebyshevSeries& function);

/// Cubic spline on [0, 1] from the coefficients of its B-splines: at least four; evenly spaced inner knots, fourfold
/// end knots.
numerics::PiecewiseChebyshevSeries make_bspline(const std::vector<double>& controls);

/// Clamped cubic spline with zero value and rate at both ends, followed by its derivatives. n coefficients have the
/// inner knots k / (n + 1); with a jump, the n − 1 inner knots k / n, the middle one double.
/// @throws std::invalid_argument if there is no coefficient or, with a jump, an odd number of them
numerics::PiecewiseChebyshevSeries make_clamped_bspline(const std::vector<double>& coefficients, bool jump);

/// Adds a trajectory's secondary tasks and corridor offset to a request with known `from`, `to` and `via`.
/// @throws std::invalid_argument if the quantity of a task is not driven, a task has not been solved yet, or the path
///        is a table. The message is suitable for users.
void add_secondary_tasks(const Trajectory& trajectory, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request);

/// Why the moves of a course are not one after the other within a duration: "it would arrive at 2.3 s, but the motion ends
/// at 2 s"; empty if they are.
std::string find_course_issue(const CoordinateCourse& course, double duration);

/// Adds the trajectory's courses to a request with known `from`, `to`, `via`, path and duration; both ends of every move become
/// switch times.
/// @throws std::invalid_argument if a move is not within the duration, or its law moves from other than rest to rest
void add_courses(const Trajectory& trajectory, const DriveQuantities& quantities, PrescribedMotion::Request& request);

/// Number of leading components of a drive that are the point of a corridor: the coordinates of the tool or the centre
/// of mass, or all driven joint coordinates.
/// @throws std::invalid_argument if there are fewer than two. The message is suitable for users.
int count_corridor_components(const DriveQuantities& quantities);

/// Unit vectors perpendicular to a line, circle or arc and to each other. Immutable.
class PathNormals {
 public:
  /// @param components number of components of the point, the leading ones of the request
  /// @param width of the corridor
  /// @throws std::invalid_argument if the path is of another kind or has zero length, or a radius does not exceed the
  ///        width. The message is suitable for users.
  PathNormals(const PrescribedMotion::Request& request, int components, double width);

  /// Number of components of the point minus one.
  Eigen::Index count() const { return components_ - 1; }
  /// @param s path parameter, 0 to 1
  /// @return one normal per column; in the plane, to the left of a line or outwards of a circle
  MatrixX at(double s) const;
  /// Angle by which they turn along the whole path [rad].
  double sweep() const { return circle_ ? circle_->sweep : 0; }

 private:
  Eigen::Index components_;
  MatrixX straight_;  ///< for a line
  std::optional<CircularCurve> circle_;
};

/// The cubic splines of a corridor on evenly spaced knots, zero at both ends; one function per `knots + 2` controls.
numerics::PiecewiseChebyshevSeries make_corridor_splines(const std::vector<double>& controls, int knots);

/// Adds the offset found for a trajectory's corridor to a request with known path and ends. Does nothing without a
/// corridor.
/// @throws std::invalid_argument if the offset has not been found yet, or as above
void add_corridor_offset(const std::optional<Corridor>& corridor, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request);

}  // namespace balance::trajectory
