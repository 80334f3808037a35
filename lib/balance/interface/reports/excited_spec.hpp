#pragma once
/// The spec with a trajectory along which to measure, and the motion as a table for a robot's controller.

#include "balance/motion/study/study.hpp"
#include "balance/synthesis/identification/excitation.hpp"

#include <string>

namespace balance::reports {

struct ExcitedSpec {
  std::string text;
  /// Largest differences between the trajectory as simulate() moves along it and the series, relative to the largest
  /// values of each coordinate.
  double position_error = 0, acceleration_error = 0;
  /// The same of the efforts that simulate() finds and those of the regressor; relative to the peak of each channel. NaN
  /// if the channels are not efforts of actuators.
  double effort_error = 0;
};

/// The text that a study was read from with a further trajectory, a table that a cubic spline joins. Comments and layout
/// are preserved. The text is read again, and the mechanism moved along the trajectory.
/// @throws SpecError if the spec's form does not allow it, or the mechanism cannot move along it
ExcitedSpec format_excited_spec(const Study& study, const identification::Excitation& excitation,
                                const std::string& name);

/// Time, positions and rates of the independent coordinates in the units of the spec; columns are named as those of the
/// records that identify reads. @param step between rows [s]
std::string format_excitation_csv(const Study& study, const identification::Excitation& excitation, double step);

}  // namespace balance::reports
