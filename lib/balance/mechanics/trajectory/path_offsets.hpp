#pragma once
/// How a path is left within its corridor: in directions at right angles to it, by cubic splines over the way.

#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/mechanics/trajectory/geometric_path.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>

namespace balance {

// What the quantities of a drive do besides going along their path, as functions of one parameter.

/// A course's value and its first and second derivative with respect to its parameter.
struct ValueWithDerivatives {
  double value = 0, first = 0, second = 0;
};

/// @param course functions: value, first and second derivative, over 0 to 1
/// @param side which limit to take where the second derivative jumps
ValueWithDerivatives evaluate_with_derivatives(const PiecewiseChebyshevSeries& course, double parameter, Side side);

/// A function with its first two derivatives beside it.
PiecewiseChebyshevSeries append_derivatives(const PiecewiseChebyshevSeries& function);

/// A cubic spline over 0 to 1 by the controls of its B-splines: at least four, the inner knots evenly spaced, the ends fourfold.
PiecewiseChebyshevSeries make_bspline(const std::vector<double>& controls);

/// The clamped cubic spline with value and rate zero at both ends, as a course. Of n coefficients it has the inner knots k / (n + 1);
/// with a jump the n − 1 inner knots k / n, the one in the middle double.
/// @throws std::invalid_argument if there is no coefficient or, with a jump, an odd number of them
PiecewiseChebyshevSeries make_clamped_bspline(const std::vector<double>& coefficients, bool jump);

/// Puts a trajectory's courses and the way within its corridor into a schedule's request, whose `from`, `to` and `via` are known.
/// @throws std::invalid_argument if a course is no quantity of the drive, has not been found yet, or goes beside a table. The message
///         is fit for a user.
void add_secondary_tasks(const Trajectory& trajectory, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request);

/// How many leading components of a drive are the point that a corridor is for: the coordinates of the tool or the centre of mass, or
/// all driven joint coordinates.
/// @throws std::invalid_argument if they are fewer than two. The message is fit for a user.
int count_corridor_components(const DriveQuantities& quantities);

/// Unit vectors at right angles to a line, circle or arc and to each other. Immutable.
class PathNormals {
 public:
  /// @param components of the point, the leading ones of the request's
  /// @param width of the corridor
  /// @throws std::invalid_argument if the path is another one or goes nowhere, or a radius is no larger than the width. The message is
  ///         fit for a user.
  PathNormals(const PrescribedMotion::Request& request, int components, double width);

  /// As many as the point has components, less one.
  Eigen::Index count() const { return components_ - 1; }
  /// @param s path parameter, 0 to 1 @return one column each: of the plane the one to the left of a line, outwards of a circle
  MatrixX at(double s) const;
  /// How far they turn along the whole path [rad].
  double sweep() const { return circle_ ? circle_->sweep : 0; }

 private:
  Eigen::Index components_;
  MatrixX straight_;  ///< of a line
  std::optional<CircularCurve> circle_;
};

/// The cubic splines of a corridor on its evenly spaced knots, zero at both ends, one function for each `knots + 2` of the controls.
PiecewiseChebyshevSeries make_corridor_splines(const std::vector<double>& controls, int knots);

/// Puts the way found in a trajectory's corridor into a request whose path and ends are known. Without a corridor nothing is done.
/// @throws std::invalid_argument if the way has not been found yet, or as above
void add_corridor_offset(const std::optional<Corridor>& corridor, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request);

}  // namespace balance
