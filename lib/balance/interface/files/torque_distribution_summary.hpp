#pragma once
/// How a run's efforts were distributed over redundant actuators, as text and JSON.

#include "balance/interface/files/report_fields.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>

namespace balance::files {

/// The method, and for every actuator its weight, limits, preload and largest excess, where there are any; ends with a
/// newline. @pre the result has a torque distribution
std::string format_torque_distribution(const RunResult& result, const specification::SpecUnits& units = {});

/// {method, weights: {A1: 1}, limits: {A1: [lowest, highest]}, preload: {A1: 2}, excesses: [{actuator, unit, excess,
/// time, torque, bound, from, until}]}; SI. @pre the result has a torque distribution
Json torque_distribution_json(const RunResult& result);

}  // namespace balance::files
