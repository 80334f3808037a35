#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"
#include "run_operands.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/reports/tolerance_sections.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/study.hpp"

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

Trajectory choose_trajectory(const ToleranceOptions& options, const Study& study) {
  if (study.trajectories.empty())
    throw SpecError({.place = {.file = study.spec_file}, .message = "there is no motion; only --at-rest needs none"});
  Trajectory trajectory = study::choose_trajectory(study, options.trajectory);
  if (options.samples) trajectory.samples = *options.samples;
  return trajectory;
}

void check_quantities(const ToleranceOptions& options, const Mechanism& mechanism) {
  const std::vector<std::string> names = results::list_metric_names(mechanism);
  for (const std::string& name : options.of)
    if (std::find(names.begin(), names.end(), results::resolve_quantity_name(name, names)) == names.end())
      throw UsageError(fmt::format("--of {}: expected {}{}", quote_for_message(name), join_alternatives(names),
                                   append_nearest_name(name, names)));
}

/// Checks before the computation that the output can be written.
void check_deviations_output(const ToleranceOptions& options, const Study& study) {
  check_standard_output({options.output}, options.spec.json, options.output == files::standard_output_path);
  check_output(options.output, "the result", FileFormat::hdf5, list_input_files(study), options.force);
}

std::vector<std::string> write_deviations(const ToleranceOptions& options, const Study& study,
                                          const reports::ToleranceReportData& view) {
  if (options.output.empty()) return {};
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  const reports::ToleranceCommand call{.of = options.of, .samples = options.samples};
  write_tolerance(options.output, view, make_tolerance_provenance(study, choose_trajectory(options, study), call),
                  write);
  return {options.output};
}

reports::ToleranceReportData compute_tolerance_data(const ToleranceOptions& options,
                                                    const specification::TolerancedDesignSpace& spec) {
  const Study& study = spec.space.start;
  reports::ToleranceReportData view{.mechanism = study.mechanism.name, .trajectory = {}, .numbers = spec.tolerances};
  view.draws = {options.draws, options.seed};
  if (options.at_rest) {
    view.at_rest = tolerance::analyse_static_tolerance(spec.space, spec.tolerances);
    if (view.at_rest->outcome.status != MotionStatus::done) throw MotionFailure(view.at_rest->outcome);
    return view;
  }
  const Trajectory trajectory = choose_trajectory(options, study);
  view.trajectory = trajectory.name;
  view.report = tolerance::analyse_tolerance(spec.space, spec.tolerances, trajectory, options.of);
  if (view.report->outcome.status != MotionStatus::done) throw MotionFailure(view.report->outcome);
  if (options.draws == 0) return view;
  const Tolerances drawn_tolerances =
      remove_incompatible_parameters(spec.tolerances, view.report->incompatible_parameters);
  ProgressLine line(false);
  view.sampling = sample_tolerance(spec.space, drawn_tolerances, trajectory, options.of, view.draws,
                                   [&](double fraction) { line.draw_fraction("draws", fraction); });
  return view;
}

ExitCode run(const ToleranceOptions& options) {
  const specification::TolerancedDesignSpace spec =
      read_toleranced_space_file(options.spec.spec, read_options(options.spec));
  const Study& study = spec.space.start;
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (spec.tolerances.empty())
    throw SpecError({.place = specification::locate_key(study, "tolerances"),
                     .message = "missing: expected the numbers that may deviate"});
  check_quantities(options, study.mechanism);
  check_deviations_output(options, study);
  if (!options.at_rest) choose_trajectory(options, study);
  try {
    const reports::ToleranceReportData view = compute_tolerance_data(options, spec);
    const std::vector<std::string> files = write_deviations(options, study, view);
    if (options.spec.json) {
      print(tolerance_json(view));
    } else {
      std::string text = tolerance_text(view, choose_design_text_options(options.spec, study));
      for (const std::string& file : files) text += "\n" + format_written_message(file);
      print_status(files, text);
    }
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = specification::locate_key(study, "tolerances"), .message = error.what()});
  }
  return ExitCode::done;
}

void add_tolerance_options(CLI::App& parser, ToleranceOptions& o) {
  add_spec_options(parser, o.spec);
  add_units_option(parser, o.spec.units);
  CLI::Option* trajectory =
      parser.add_option("-t,--trajectory", o.trajectory, "trajectory of the spec (default: the first)")
          ->type_name("NAME");
  parser.add_option("--of", o.of, "quantity, such as torque[A1] or shaking_force (default: all)")->type_name("NAME");
  parser.add_option("--samples", o.samples, "number of samples, both ends included")
      ->type_name("N")
      ->check(integer_range_validator(trajectory::min_samples, trajectory::max_samples));
  CLI::Option* draws = parser.add_option("--monte-carlo", o.draws, "also run N mechanisms with randomly drawn numbers")
                           ->type_name("N")
                           ->check(integer_range_validator(2, tolerance::max_tolerance_draws));
  parser.add_option("--seed", o.seed, "seed of the draws")
      ->type_name("S")
      ->check(integer_range_validator(0, study::max_seed))
      ->needs(draws)
      ->capture_default_str();
  CLI::Option* output =
      parser.add_option("-o,--output", o.output, "write the run and the deviation of every sample to this HDF5 file")
          ->type_name("FILE");
  parser.add_flag("--force", o.force, "overwrite an existing file")->needs(output);
  parser.add_flag("--at-rest", o.at_rest, "efforts at rest in all poses instead of a trajectory")
      ->excludes(trajectory)
      ->excludes(draws)
      ->excludes(output);
}

}  // namespace

Command setup_tolerance(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("tolerance", "Deviation of torques and shaking forces due to tolerances");
  const auto options = std::make_shared<ToleranceOptions>();
  add_tolerance_options(*parser, *options);
  parser->footer(
      "The spec's `tolerances` say which numbers may deviate, and how far. Prints the standard deviation\n"
      "of every figure to first order, by exact derivatives; the sample with the largest deviation, and\n"
      "the numbers that cause it; and for figures that vanish (a balanced force) the root of the expected\n"
      "mean square. Numbers are independent of each other.\n\n"
      "--monte-carlo runs mechanisms with randomly drawn numbers and prints mean, deviation and quantiles\n"
      "with standard errors. Draws that are not valid mechanisms or cannot move are counted.\n\n"
      "Examples:\n"
      "  balance tolerance rr.yaml --trajectory cycloid\n"
      "  balance tolerance rr.yaml --of shaking_force --monte-carlo 1000 --seed 7\n"
      "  balance tolerance rr.yaml -o deviations.h5\n"
      "  balance tolerance rr.yaml --at-rest --json");
  return {parser, [options] {
            split_trajectory_name(options->spec.spec, options->trajectory);
            return run(*options);
          }};
}

}  // namespace balance::app
