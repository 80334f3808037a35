#include "console.hpp"
#include "control_options.hpp"
#include "failure.hpp"
#include "progress_line.hpp"
#include "run_output.hpp"
#include "spec_run.hpp"

#include "balance/analysis/control.hpp"
#include "balance/base/error.hpp"
#include "balance/result/body_poses.hpp"
#include "balance/study/passing_payloads.hpp"

#include <memory>

namespace balance::app {
namespace {

RunResult control_or_throw(const Study& study, const Trajectory& trajectory, const Controller& controller,
                           const ControlCommandOptions& options) {
  ProgressLine line(options.run.quiet);
  const auto progress = [&](double part) { line.draw_fraction(trajectory.name, part); };
  try {
    return simulate_closed_loop(study.mechanism, trajectory, controller,
                                {.hold_time = options.settle, .max_steps = options.steps, .progress = progress});
  } catch (const std::invalid_argument& error) {
    // The library was asked something that the spec should not have asked.
    throw SpecError({.place = {.file = study.spec_file,
                               .key = "trajectories." + trajectory.name + ", controllers." + controller.name},
                     .message = error.what()});
  }
}

ExitCode run(const ControlCommandOptions& options) {
  const SimulateOptions& shared = options.run;
  const Study study = read_study(shared.spec);
  reject_temporary_payloads(study, "a controlled run");
  const Trajectory trajectory = choose_trajectory(shared, study);
  const Controller controller = choose_controller(options, study);
  check_outputs(shared, study);
  print_run_header(shared, study, trajectory);
  if (options.controller.empty() && !shared.quiet)
    print_message("note: no --controller given: '" + controller.name + "' is taken");
  RunResult result = control_or_throw(study, trajectory, controller, options);
  if (shared.poses && result.time.size() > 0) add_body_poses(study.mechanism, result);
  print_notes(shared, result);
  const Provenance description = describe(options, study, trajectory, controller);
  // What was computed until something stopped the run is worth keeping; the file says that it ended early.
  const bool done = result.outcome.status == MotionStatus::done;
  std::vector<std::string> files;
  if (result.time.size() >= 2) files = write_files(shared, result, description);
  if (!done) {
    for (const std::string& file : files) print_message("written up to where the run ended: " + file);
    throw MotionFailure(result.outcome);
  }
  print_result(shared, result, description, files);
  return ExitCode::done;
}

}  // namespace

Command setup_control(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("control", "Let a controller lead a mechanism along a trajectory");
  const auto options = std::make_shared<ControlCommandOptions>();
  add_control_options(*parser, *options);
  parser->footer(
      "The mechanism moves by its own dynamics under the efforts of a controller that samples it at its\n"
      "own rate: one of the spec's 'controllers', or, without being listed there, computed-torque, pd,\n"
      "sliding-mode, extended-sliding-mode, open-loop, none.\n\n"
      "Prints tracking errors, torques, how much they change, shaking forces; the samples go to the files\n"
      "asked for, which docs/file-format.md describes. A singular configuration on the way ends the run\n"
      "with code 4; the files then hold what was computed until there.\n\n"
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

}  // namespace balance::app
