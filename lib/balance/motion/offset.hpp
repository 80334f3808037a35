#pragma once
/// How a path is left within its corridor: in directions at right angles to it, by cubic splines over the way.

#include "balance/motion/corridor.hpp"
#include "balance/motion/curve.hpp"
#include "balance/motion/drive_quantities.hpp"
#include "balance/motion/schedule.hpp"

#include <optional>

namespace balance {

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
