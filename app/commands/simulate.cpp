#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "run_operands.hpp"
#include "run_options.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/mechanics/dynamics/effort_breakdown.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/motion/simulation/feasible_assembly_modes.hpp"
#include "balance/motion/simulation/prediction.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <memory>

namespace balance::app {
namespace {

RunResult simulate_or_throw(const Study& study, const Trajectory& trajectory, const SimulateOptions& options) {
  ProgressLine line(options.quiet);
  const auto progress = [&](double fraction) { line.draw_fraction(trajectory.name, fraction); };
  try {
    RunResult result = options.formulation == "natural"
                           ? verification::simulate_natural(study.mechanism, trajectory, progress)
                           : simulate(study.mechanism, trajectory, progress);
    simulation::add_measured_efforts(study, trajectory, result);
    if (result.outcome.status == MotionStatus::done) return result;
    if (!trajectory.free_motion)
      result.outcome.reason += simulation::describe_feasible_modes(study.mechanism, trajectory, result.outcome);
    throw MotionFailure(result.outcome, study, trajectory.name);
  } catch (const std::invalid_argument& error) {
    // The options are valid, so the error is in the spec.
    throw SpecError({.place = specification::locate_trajectory(study, trajectory), .message = error.what()});
  }
}

void add_parts(const Study& study, const Trajectory& trajectory, RunResult& result) {
  try {
    const MotionOutcome outcome = dynamics::add_effort_breakdown(mechanism_along(study, trajectory.name), result);
    if (outcome.status != MotionStatus::done) throw MotionFailure(outcome);
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = specification::locate_trajectory(study, trajectory), .message = error.what()});
  }
}

void add_orders(const SimulateOptions& options, RunResult& result) {
  try {
    result.orders = std::make_shared<const results::OrderAnalysis>(
        results::analyse_orders(result, *options.orders, options.fluctuation));
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--orders: ") + error.what());
  }
}

RunResult evaluate_state_or_throw(const SimulateOptions& options, const Study& study) {
  StateOptions pose = options.state;
  pose.trajectory = options.trajectory;
  const InverseOptions of_state = choose_state_options(options, study);
  const bool by_options = !pose.rates.empty() || !pose.accelerations.empty() || !pose.independent.empty();
  RunResult result = call_library(
      by_options, study, [&] { return evaluate_single_state(study.mechanism, read_state(pose, study), of_state); });
  if (result.outcome.status != MotionStatus::done) throw MotionFailure(result.outcome);
  return result;
}

ExitCode run_single_state(const SimulateOptions& options, const Study& study) {
  check_outputs(options, study);
  if (!options.quiet)
    for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  RunResult result = evaluate_state_or_throw(options, study);
  if (options.poses) add_body_poses(study.mechanism, result);
  print_notes(options, result);
  const files::Provenance description = describe_state(options, study);
  print_result(options, study, result, description, write_files(options, result, description));
  return ExitCode::done;
}

ExitCode run(const SimulateOptions& options) {
  const Study study = read_study(options.spec);
  if (!options.state.at.empty()) return run_single_state(options, study);
  const Trajectory trajectory = choose_trajectory(options, study);
  check_formulation(options, study);
  check_outputs(options, study);
  print_run_header(options, study, trajectory);
  RunResult result = simulate_or_throw(study, trajectory, options);
  if (options.poses) add_body_poses(mechanism_along(study, trajectory.name), result);
  if (options.split) add_parts(study, trajectory, result);
  if (options.orders) add_orders(options, result);
  print_notes(options, result);
  const files::Provenance description = describe(options, study, trajectory);
  print_result(options, study, result, description, write_files(options, result, description));
  return ExitCode::done;
}

}  // namespace

Command setup_simulate(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("simulate", "Move a mechanism along a trajectory: torques, shaking forces");
  const auto options = std::make_shared<SimulateOptions>();
  add_simulate_options(*parser, *options);
  parser->footer(
      "Prints peak, rms and mean of every quantity; --output and --csv write the samples\n"
      "(docs/file-format.md).\n\n"
      "With --at, prints every quantity at a single state instead: a pose with the --rates and\n"
      "--accelerations of the independent coordinates.\n\n"
      "Examples:\n"
      "  balance simulate 3rrr.yaml --trajectory cycloid\n"
      "  balance simulate 5r.yaml --at \"tool: [0.1, 0.3]\" --rates A1=2,A2=-1 --json\n"
      "  balance simulate 3rrr.yaml -t bang-bang -o out.h5 --force\n"
      "  balance simulate 3rrr.yaml -t cycloid --set l=0.2 --samples 2001 --csv out.csv");
  return {parser, [options] {
            split_trajectory_name(options->spec.spec, options->trajectory);
            return run(*options);
          }};
}

}  // namespace balance::app
