#pragma once
/// Runs along a motion that a machine was measured in, and what the measured efforts differ by.

#include "balance/motion/simulation/measurement_record.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance::simulation {

/// A record as a motion: low-passed alike without delay, without the rows at both ends that the filter distorts.
struct MeasuredMotion {
  std::vector<double> time;  ///< even [s]
  Samples position;          ///< rows × coordinates [rad or m]
  study::MeasuredEfforts measured;
};

/// Turns currents of actuators whose gains are known into efforts, where these were not measured themselves.
/// @param gains effort per current [N m/A or N/A]
void convert_currents(MeasurementRecord& record, const Mechanism& mechanism,
                      const std::vector<std::pair<CoordinateId, double>>& gains);

/// Positions are low-passed at three times the cut-off, efforts at the cut-off, as identification does.
/// @param coordinates whose positions the motion follows
/// @param actuators of the mechanism; the record has the efforts of all of them or of none
/// @param cutoff [Hz]; 0: from the motion
/// @throws std::invalid_argument if the record has a gap, or is shorter than its filter needs, or lacks a column
MeasuredMotion smooth_record(const MeasurementRecord& record, const Mechanism& mechanism,
                             const std::vector<CoordinateId>& coordinates, double cutoff);

/// Adds measured efforts and residuals with their figures to a run along a trajectory that follows a record. Other runs,
/// and those that did not end, are not changed. Computed efforts are low-passed like the measured ones.
void add_measured_efforts(const Study& study, const Trajectory& trajectory, RunResult& result);

/// The run, with what was measured along it.
RunResult simulate(const Study& study, const Trajectory& trajectory, const Progress& progress = {});

}  // namespace balance::simulation

namespace balance {

using simulation::simulate;

}  // namespace balance
