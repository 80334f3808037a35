#include "command.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "progress_line.hpp"
#include "signals.hpp"
#include "spec_run.hpp"
#include "value_check.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/present/tolerance_hdf5.hpp"
#include "balance/present/tolerance_json.hpp"
#include "balance/present/tolerance_text.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/tracks.hpp"
#include "balance/spec/limits.hpp"
#include "balance/spec/read_tolerances.hpp"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

namespace balance::app {
namespace {

struct ToleranceOptions {
  SpecOptions spec;
  std::string trajectory;  ///< empty: the first of the spec
  std::vector<std::string> of;
  std::optional<long> samples;
  long draws = 0;  ///< 0: none
  std::uint64_t seed = 1;
  bool at_rest = false;
  std::string output;  ///< HDF5 file to write; empty: none
  bool force = false;
};

Trajectory choose(const ToleranceOptions& options, const Study& study) {
  if (study.trajectories.empty())
    throw SpecError({.place = {.file = study.spec_file}, .message = "there is no motion: --at-rest needs none"});
  std::vector<std::string> names;
  for (const Trajectory& one : study.trajectories) {
    names.push_back(one.name);
    if (!options.trajectory.empty() && one.name != options.trajectory) continue;
    Trajectory trajectory = one;
    if (options.samples) trajectory.samples = *options.samples;
    return trajectory;
  }
  throw UsageError(fmt::format("--trajectory {}: expected {}{}", in_quotes(options.trajectory), one_of(names),
                               nearest_hint(options.trajectory, names)));
}

void check_quantities(const ToleranceOptions& options, const Mechanism& mechanism) {
  const std::vector<std::string> names = figure_names(mechanism);
  for (const std::string& name : options.of)
    if (std::find(names.begin(), names.end(), known_quantity(name, names)) == names.end())
      throw UsageError(
          fmt::format("--of {}: expected {}{}", in_quotes(name), one_of(names), nearest_hint(name, names)));
}

/// Refuses at once what would fail after the computation.
void check_deviations_output(const ToleranceOptions& options, const Study& study) {
  check_standard_output({options.output}, options.spec.json, options.output == standard_output);
  check_output(options.output, "the result", inputs_of(study), options.force);
}

std::vector<std::string> write_deviations(const ToleranceOptions& options, const Study& study,
                                          const ToleranceView& view) {
  if (options.output.empty()) return {};
  WriteOptions write;
  write.existing = options.force ? Existing::replace : Existing::keep;
  write.cancelled = [] { return pending_signal() != 0; };
  const DeferSignals deferred;
  const ToleranceCall call{.of = options.of, .samples = options.samples, .set = options.spec.set};
  write_tolerance(options.output, view, describe_tolerance(study, choose(options, study), call), write);
  return {options.output};
}

ToleranceView look(const ToleranceOptions& options, const TolerancedSpace& spec) {
  const Study& study = spec.space.start;
  ToleranceView view{.mechanism = study.mechanism.name, .trajectory = {}, .numbers = spec.tolerances};
  view.draws = {options.draws, options.seed};
  if (options.at_rest) {
    view.at_rest = tolerance_at_rest(spec.space, spec.tolerances);
    if (view.at_rest->outcome.status != MotionStatus::done) throw MotionFailure(view.at_rest->outcome);
    return view;
  }
  const Trajectory trajectory = choose(options, study);
  view.trajectory = trajectory.name;
  view.report = tolerance(spec.space, spec.tolerances, trajectory, options.of);
  if (view.report->outcome.status != MotionStatus::done) throw MotionFailure(view.report->outcome);
  if (options.draws == 0) return view;
  const Tolerances drawn = without_openings(spec.tolerances, view.report->openings);
  ProgressLine line(false);
  view.sampling = sample_tolerance(spec.space, drawn, trajectory, options.of, view.draws,
                                   [&](double part) { line.draw_part("draws", part); });
  return view;
}

ExitCode run(const ToleranceOptions& options) {
  const TolerancedSpace spec = read_toleranced_file(options.spec.spec, read_options(options.spec));
  const Study& study = spec.space.start;
  for (const std::string& warning : study.warnings) tell("warning: " + warning);
  if (spec.tolerances.empty())
    throw SpecError({.place = {.file = study.spec_file, .key = "tolerances"},
                     .message = "missing: it says which numbers may be off"});
  check_quantities(options, study.mechanism);
  check_deviations_output(options, study);
  try {
    const ToleranceView view = look(options, spec);
    const std::vector<std::string> files = write_deviations(options, study, view);
    if (options.spec.json) {
      print(tolerance_json(view));
    } else {
      std::string text = tolerance_text(view);
      for (const std::string& file : files) text += "\n" + written_line(file);
      print_beside(files, text);
    }
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = {.file = study.spec_file, .key = "tolerances"}, .message = error.what()});
  }
  return ExitCode::done;
}

void add_tolerance_options(CLI::App& parser, ToleranceOptions& o) {
  add_spec_options(parser, o.spec);
  CLI::Option* trajectory =
      parser.add_option("-t,--trajectory", o.trajectory, "which trajectory of the spec; the first if not given")
          ->type_name("NAME");
  parser.add_option("--of", o.of, "which quantities: torque, torque[A1], shaking_force; all if not given")
      ->type_name("NAME");
  parser.add_option("--samples", o.samples, "number of samples, both ends included")
      ->type_name("N")
      ->check(whole_number(min_samples, max_samples));
  CLI::Option* draws =
      parser.add_option("--monte-carlo", o.draws, "run so many mechanisms with numbers drawn at random, too")
          ->type_name("N")
          ->check(whole_number(2, most_tolerance_draws));
  parser.add_option("--seed", o.seed, "of the draws")
      ->type_name("S")
      ->check(whole_number(0, max_seed))
      ->needs(draws)
      ->capture_default_str();
  CLI::Option* output =
      parser.add_option("-o,--output", o.output, "write the run and the deviation of every sample to this HDF5 file")
          ->type_name("FILE");
  parser.add_flag("--force", o.force, "replace a file that exists")->needs(output);
  parser.add_flag("--at-rest", o.at_rest, "efforts at rest in all poses instead of a trajectory")
      ->excludes(trajectory)
      ->excludes(draws)
      ->excludes(output);
}

}  // namespace

Command setup_tolerance(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("tolerance", "How far torques and shaking are off when numbers are");
  const auto options = std::make_shared<ToleranceOptions>();
  add_tolerance_options(*parser, *options);
  parser->footer(
      "The spec's `tolerances` say which numbers may be off, and how far. Prints the standard\n"
      "deviation of every figure to first order, by exact derivatives; the sample that is off most, and\n"
      "which numbers make it so; and for what vanishes (a balanced force) the root of its expected mean\n"
      "square. Numbers are independent of each other.\n\n"
      "--monte-carlo runs mechanisms with numbers drawn at random and tells mean, deviation and\n"
      "quantiles with standard errors. Draws that are no mechanism or cannot move are counted.\n\n"
      "Examples:\n"
      "  balance tolerance rr.yaml --trajectory cycloid\n"
      "  balance tolerance rr.yaml --of shaking_force --monte-carlo 1000 --seed 7\n"
      "  balance tolerance rr.yaml -o deviations.h5\n"
      "  balance tolerance rr.yaml --at-rest --json");
  return {parser, [options] {
            take_trajectory(options->spec.spec, options->trajectory);
            return run(*options);
          }};
}

}  // namespace balance::app
