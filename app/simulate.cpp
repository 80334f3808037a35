#include "console.hpp"
#include "failure.hpp"
#include "run_files.hpp"
#include "simulate_options.hpp"

#include "balance/base/error.hpp"
#include "balance/study/simulate.hpp"
#include "balance/study/simulate_natural.hpp"
#include "balance/write/json.hpp"
#include "balance/write/text.hpp"

#include <memory>

namespace balance::app {
namespace {

Result simulate_or_throw(const Study& study, const Trajectory& trajectory, const std::string& formulation) {
  try {
    Result result = formulation == "natural" ? simulate_natural(study.mechanism, trajectory)
                                             : simulate(study.mechanism, trajectory);
    if (result.outcome.status != MotionStatus::done) throw MotionFailure(result.outcome);
    return result;
  } catch (const std::invalid_argument& error) {
    // The library was asked something that the spec should not have asked.
    throw SpecError(study.spec_file + ": trajectories." + trajectory.name + ": " + error.what());
  }
}

ExitCode run(const SimulateOptions& options) {
  const Study study = read_study(options.spec);
  const Trajectory trajectory = choose_trajectory(options, study);
  check_formulation(options, study);
  check_outputs(options);
  const auto note = [&](const std::string& text) {
    if (!options.quiet) tell(text);
  };
  for (const std::string& warning : study.warnings) note("warning: " + warning);
  if (options.trajectory.empty() && study.trajectories.size() > 1) {
    note("note: no --trajectory given: '" + trajectory.name + "' is the first in the spec");
  }
  const Result result = simulate_or_throw(study, trajectory, options.formulation);
  for (const std::string& text : result.outcome.notes) note("note: " + text);
  const FileDescription description = describe(options, study, trajectory);
  const std::vector<std::string> files = write_files(options, result, description);
  if (options.spec.json) {
    print(result_json(result, description, files));
  } else if (!options.quiet) {
    std::string text = summary_text(result, description);
    for (const std::string& file : files) text += "written: " + file + "\n";
    print(text);
  }
  return ExitCode::done;
}

}  // namespace

Command setup_simulate(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("simulate", "Move a mechanism along a trajectory: torques, shaking forces");
  const auto options = std::make_shared<SimulateOptions>();
  add_simulate_options(*parser, *options);
  parser->footer(
      "Prints peak, rms and mean of every quantity; the samples go to the files asked for, which\n"
      "docs/file-format.md describes.\n\n"
      "Examples:\n"
      "  balance simulate 3rrr.yaml --trajectory cycloid\n"
      "  balance simulate 3rrr.yaml -t bang-bang -o out.h5 --force\n"
      "  balance simulate 3rrr.yaml -t cycloid --set l=0.2 --samples 2001 --csv out.csv");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
