#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/control/controller_error.hpp"
#include "balance/motion/study/study.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/validators.hpp"
#include "run_operands.hpp"
#include "run_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>
#include <memory>

namespace balance::app {
namespace {

RunResult control_or_throw(const Study& study, const Trajectory& trajectory, const Controller& controller,
                           const ControlCommandOptions& options) {
  ProgressLine line(options.run.quiet);
  const auto progress = [&](double fraction) { line.draw_fraction(trajectory.name, fraction); };
  try {
    return simulate_closed_loop(study.mechanism, trajectory, controller,
                                {.hold_time = options.settle, .max_steps = options.steps, .progress = progress});
  } catch (const control::ControllerError& error) {
    const std::string key = "controllers." + controller.name + (error.key().empty() ? "" : "." + error.key());
    throw SpecError({.place = specification::locate_key(study, key),
                     .message = fmt::format("along trajectory '{}': {}", trajectory.name, error.what())});
  } catch (const std::invalid_argument& error) {
    // The options are valid, so the error is in the spec.
    throw SpecError({.place = specification::locate_key(study, "trajectories." + trajectory.name),
                     .message = fmt::format("with controller '{}': {}", controller.name, error.what())});
  }
}

ExitCode run(const ControlCommandOptions& options) {
  const SimulateOptions& run_options = options.run;
  const Study study = read_study(run_options.spec);
  const Trajectory trajectory = choose_trajectory(run_options, study);
  const Controller controller = choose_controller(study, options.controller);
  check_outputs(run_options, study);
  print_run_header(run_options, study, trajectory);
  if (options.controller.empty() && !run_options.quiet)
    print_message("note: no --controller given: using '" + controller.name + "'");
  RunResult result = control_or_throw(study, trajectory, controller, options);
  if (run_options.poses && result.time.size() > 0) add_body_poses(mechanism_along(study, trajectory.name), result);
  print_notes(run_options, result);
  const files::Provenance description = describe(options, study, trajectory, controller);
  // The part before a run stopped is worth keeping; the file records that the run ended early.
  const bool done = result.outcome.status == MotionStatus::done;
  std::vector<std::string> files;
  if (result.time.size() >= 2) files = write_files(run_options, result, description);
  if (!done) {
    for (const std::string& file : files) print_message("written up to where the run ended: " + file);
    throw MotionFailure(result.outcome, study, trajectory.name);
  }
  print_result(run_options, study, result, description, files);
  return ExitCode::done;
}

}  // namespace

Command setup_control(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("control", "Simulate a controller moving a mechanism along a trajectory");
  const auto options = std::make_shared<ControlCommandOptions>();
  add_control_options(*parser, *options);
  parser->footer(
      "The mechanism moves by its own dynamics under the efforts of a controller that samples it at its\n"
      "own rate: one of the spec's 'controllers', or a built-in one: computed-torque, pd, sliding-mode,\n"
      "extended-sliding-mode, open-loop, none.\n\n"
      "Prints tracking errors, torques and their variation, and shaking forces; --output and --csv write\n"
      "the samples (docs/file-format.md). A singular configuration on the way ends the run with exit\n"
      "code 4; the files then contain the run up to that point.\n\n"
      "Examples:\n"
      "  balance control 5r.yaml --trajectory cycloid --controller computed-torque\n"
      "  balance control 5r.yaml -t circle -c sliding-mode -o out.h5 --force\n"
      "  balance control arm.yaml -t cycloid -c none --duration 10 --json\n"
      "  balance control arm.yaml -t cycloid -c pd --settle 0.5 --csv out.csv");
  return {parser, [options] {
            split_trajectory_name(options->run.spec.spec, options->run.trajectory);
            return run(*options);
          }};
}

void add_control_options(CLI::App& parser, ControlCommandOptions& o) {
  add_run_options(parser, o.run);
  CLI::Option* controller =
      parser.add_option("-c,--controller", o.controller, "controller (default: the first of the spec)");
  controller->type_name("NAME");
  parser.add_option("--settle", o.settle, "time to hold the last pose, in seconds")
      ->type_name("T")
      ->check(number_range_validator(0, trajectory::max_duration));
  parser.add_option("--steps", o.steps, "limit of integration steps")
      ->type_name("N")
      ->check(integer_range_validator(1));
}

files::Provenance describe(const ControlCommandOptions& options, const Study& study, const Trajectory& trajectory,
                           const Controller& controller) {
  files::SimulateCommand command = make_simulate_command(options.run, trajectory);
  command.controller = controller.name;
  command.settle = options.settle;
  command.steps = options.steps;
  return files::make_simulation_provenance(study, trajectory, command);
}

}  // namespace balance::app
