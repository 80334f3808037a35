#include "state_options.hpp"

#include "cli/failures.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/simulation/end_configurations.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace balance::app {

namespace {

/// The trajectory that `start` and `end` refer to.
const Trajectory& choose_state_trajectory(const StateOptions& options, const Study& study) {
  if (study.trajectories.empty())
    throw UsageError(fmt::format("{} has no motion, but --at {} needs one", study.spec_file, options.at));
  return choose_trajectory(study, options.trajectory);
}

std::vector<CoordinateValue> find_state_configuration(const StateOptions& options, const Study& study) {
  const Mechanism& mechanism = study.mechanism;
  kinematics::ConfigurationResult result =
      options.at == "end"     ? simulation::find_end_configuration(mechanism, choose_state_trajectory(options, study))
      : options.at == "start" ? simulation::find_start_configuration(mechanism, choose_state_trajectory(options, study))
                              : kinematics::solve_configuration(mechanism, specification::read_pose(options.at, study));
  if (result.outcome.status != MotionStatus::done) throw MotionFailure(result.outcome);
  return std::move(result.coordinates);
}

}  // namespace

void add_state_options(CLI::App& parser, StateOptions& o, const std::string& at_help) {
  CLI::Option* at = parser.add_option("--at", o.at, at_help)->type_name("POSE")->check([](const std::string& text) {
    return text.find_first_not_of(" \t\r\n") == std::string::npos ? "expected a pose, found an empty text" : "";
  });
  parser.add_option("--rates", o.rates, "rates of the independent coordinates (default: 0)")
      ->type_name("NAME=V,...")
      ->needs(at);
  parser.add_option("--accelerations", o.accelerations, "accelerations of the independent coordinates")
      ->type_name("NAME=V,...")
      ->needs(at);
  parser.add_option("--time", o.time, "time in seconds, for loads and payloads that depend on it")
      ->type_name("T")
      ->check(number_range_validator(-trajectory::max_duration, trajectory::max_duration))
      ->needs(at);
  parser.add_option("--independent", o.independent, "independent coordinates (default: the actuated)")
      ->type_name("NAMES")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->needs(at);
}

dynamics::SingleState read_state(const StateOptions& options, const Study& study) {
  dynamics::SingleState state;
  if (!options.rates.empty()) state.rates = specification::read_coordinate_rates(options.rates, "--rates", study);
  if (!options.accelerations.empty())
    state.accelerations = specification::read_coordinate_rates(options.accelerations, "--accelerations", study);
  state.configuration = find_state_configuration(options, study);
  state.time = options.time;
  return state;
}

}  // namespace balance::app
