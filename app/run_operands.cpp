#include "run_operands.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/mechanics/dynamics/single_state.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/motion/simulation/prediction.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "run_options.hpp"
#include "state_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::app {
namespace {

/// The mechanism at rest with its actuated coordinates at their assembly values, or zero.
RunResult assembled_state(const Study& study) {
  const Mechanism& mechanism = study.mechanism;
  kinematics::ConfigurationResult assembled =
      kinematics::solve_configuration(mechanism, kinematics::actuators_as_assembled(mechanism));
  if (assembled.outcome.status != MotionStatus::done) throw MotionFailure(assembled.outcome);
  return dynamics::evaluate_single_state(mechanism, {.configuration = std::move(assembled.coordinates)});
}

files::StoredRun simulate_spec_run(const SpecTrajectoryName& name, const std::string& output, const std::string& what,
                                   AcceptedRuns accepted) {
  SimulateOptions options;
  options.spec.spec = name.spec;
  options.trajectory = name.trajectory;
  const Study study = read_study(options.spec);
  if (accepted == AcceptedRuns::motions_and_states && study.trajectories.empty() && name.trajectory.empty()) {
    check_overwrites_no_input(output, what, list_input_files(study));
    files::StoredRun state{.path = study.spec_file, .title = study.mechanism.name, .spec_text = study.spec_text};
    state.result = call_library(false, study, [&] { return assembled_state(study); });
    if (state.result.time.size() == 0) throw MotionFailure(state.result.outcome);
    return state;
  }
  const Trajectory trajectory = choose_trajectory(options, study);
  check_overwrites_no_input(output, what, list_input_files(study));
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (name.trajectory.empty() && study.trajectories.size() > 1)
    print_message(fmt::format(
        "note: {}: using {}, the first of its {} trajectories; {}", study.spec_file, quote_for_message(trajectory.name),
        study.trajectories.size(),
        name.spec == "-" ? "save the spec to a file to select another" : name.spec + ":NAME selects another"));
  files::StoredRun run{.path = study.spec_file,
                       .group = name.trajectory,
                       .title = study.mechanism.name,
                       .spec_text = study.spec_text,
                       .trajectory = trajectory.name,
                       .law = law_name(trajectory),
                       .drive = drive_name(trajectory)};
  try {
    run.result = simulate(study, trajectory);
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = specification::locate_trajectory(study, trajectory), .message = error.what()});
  }
  if (run.result.outcome.status != MotionStatus::done) throw MotionFailure(run.result.outcome, study, trajectory.name);
  return run;
}

}  // namespace

CLI::Option* add_run_operands(CLI::App& parser, std::vector<std::string>& runs) {
  CLI::Option* operands = parser.add_option(
      "runs", runs, "result files, runs of design files (design.h5:after/cycloid) or specs (arm.yaml:cycloid)");
  suggest_files(operands->required()->type_name("RUN"), {"h5", "yaml", "yml"});
  return operands;
}

void check_standard_input_once(const std::vector<std::string>& names) {
  const auto is_input = [](const std::string& name) {
    const std::optional<SpecTrajectoryName> spec = parse_spec_trajectory_name(name);
    return spec && spec->spec == "-";
  };
  if (std::count_if(names.begin(), names.end(), is_input) > 1)
    throw UsageError("standard input, -, can be read only once: save the spec to a file");
}

files::StoredRun load_or_simulate_run(const std::string& name, const std::string& output, const std::string& what,
                                      AcceptedRuns accepted) {
  const std::optional<SpecTrajectoryName> spec = parse_spec_trajectory_name(name);
  check_overwrites_no_input(output, what, {{spec ? spec->spec : name, "its input"}});
  files::StoredRun file = spec                                ? simulate_spec_run(*spec, output, what, accepted)
                          : accepted == AcceptedRuns::motions ? files::read_motion_file(name)
                                                              : read_result_file(name);
  check_overwrites_no_input(output, what, {{file.path, "its input"}});
  if (!file.ended_early.empty()) print_message("note: " + name + " ended early: " + file.ended_early);
  return file;
}

void check_run_matches_mechanism(const files::StoredRun& run, const Mechanism& mechanism) {
  std::vector<std::string> coordinates, joints;
  for (const Coordinate& coordinate : mechanism.coordinates) coordinates.push_back(coordinate.name);
  for (const Joint& joint : mechanism.joints) joints.push_back(joint.name);
  const RunResult& r = run.result;
  if (r.coordinate_names != coordinates || (!r.joint_names.empty() && r.joint_names != joints) ||
      r.axes != (mechanism.space == SpaceKind::planar ? 2 : 3))
    throw SystemError(run.path + ": is damaged: its run does not belong to the mechanism of its spec");
}

Mechanism read_run_mechanism(const files::StoredRun& run) {
  const ReadOptions options{.set = run.overrides};
  Mechanism mechanism;
  if (run.free_values.size() == 0) {
    mechanism = mechanism_along(read_spec(run.spec_text, run.path, options), run.trajectory);
  } else {
    const DesignSpace space = read_design_space(run.spec_text, run.path, options);
    if (static_cast<std::size_t>(run.free_values.size()) != space.start.free_numbers.size())
      throw SystemError(run.path + ": is damaged: its free numbers are not those of its spec");
    mechanism = space.instantiate(run.free_values).mechanism;
  }
  check_run_matches_mechanism(run, mechanism);
  return mechanism;
}

std::optional<SpecTrajectoryName> parse_spec_trajectory_name(const std::string& name) {
  if (name == "-") return SpecTrajectoryName{name, ""};
  std::error_code ignored;
  const bool exists = std::filesystem::exists(name, ignored);
  for (const std::string suffix : {".yaml", ".yml"}) {
    if (name.ends_with(suffix)) return SpecTrajectoryName{name, ""};
    if (exists) continue;
    if (const std::size_t at = name.rfind(suffix + ":"); at != std::string::npos)
      return SpecTrajectoryName{name.substr(0, at + suffix.size()), name.substr(at + suffix.size() + 1)};
  }
  return std::nullopt;
}

void split_trajectory_name(std::string& spec, std::string& trajectory) {
  const std::optional<SpecTrajectoryName> named = parse_spec_trajectory_name(spec);
  if (!named || named->trajectory.empty()) return;
  if (!trajectory.empty() && trajectory != named->trajectory)
    throw UsageError("two trajectories are named: " + quote_for_message(named->trajectory) + " and " +
                     quote_for_message(trajectory));
  spec = named->spec;
  trajectory = named->trajectory;
}

}  // namespace balance::app
