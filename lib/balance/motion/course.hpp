#pragma once
/// What the quantities of a drive do besides going along their path, as functions of one parameter.

#include "balance/base/piecewise_series.hpp"
#include "balance/motion/drive_quantities.hpp"
#include "balance/motion/schedule.hpp"

namespace balance {

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

}  // namespace balance
