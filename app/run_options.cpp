#include "run_options.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/result_summary.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace balance::app {

void print_run_header(const SimulateOptions& options, const Study& study, const Trajectory& trajectory) {
  if (options.quiet) return;
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (options.trajectory.empty() && study.trajectories.size() > 1)
    print_message("note: no --trajectory given: using '" + trajectory.name + "', the first in the spec");
}

void print_notes(const SimulateOptions& options, const RunResult& result) {
  if (options.quiet) return;
  for (const std::string& text : result.outcome.notes) print_message("note: " + text);
}

std::vector<std::string> write_files(const SimulateOptions& options, const RunResult& result,
                                     const files::Provenance& description) {
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.compression = options.compress ? files::Compression::gzip : files::Compression::none;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  std::vector<std::string> files;
  if (!options.output.empty()) {
    write_result_hdf5(options.output, result, description, write);
    files.push_back(options.output);
  }
  if (!options.csv.empty()) {
    write_result_csv(options.csv, result, write);
    files.push_back(options.csv);
  }
  return files;
}

void print_result(const SimulateOptions& options, const Study& study, const RunResult& result,
                  const files::Provenance& description, const std::vector<std::string>& files) {
  if (options.spec.json) return print(format_result_json(result, description, files));
  if (options.quiet) return;
  std::string text = format_result_summary(result, description, choose_text_options(options.spec, study));
  for (const std::string& file : files) text += format_written_message(file);
  print_status(files, text);
}

namespace {

/// Parses comma-separated numbers without whitespace.
std::optional<std::vector<double>> parse_numbers(const std::string& text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    double number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    if (next == end) return numbers;
    if (*next != ',') return std::nullopt;
    at = next + 1;
  }
}

Vector3 parse_moment_reference(const std::string& text, SpaceKind space) {
  const std::size_t axes = space == SpaceKind::planar ? 2 : 3;
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != axes) {
    throw UsageError(fmt::format("--about needs {} in metres, not '{}'", axes == 2 ? "x,y" : "x,y,z", text));
  }
  Vector3 about = Vector3::Zero();
  for (std::size_t i = 0; i < axes; ++i) about[static_cast<Eigen::Index>(i)] = (*numbers)[i];
  return about;
}

constexpr long max_order = 1000;
constexpr double min_fluctuation = 1e-9, max_fluctuation = 1;

std::vector<std::string> formulations() { return {"tree", "natural"}; }

void change_timing(Trajectory& trajectory, const SimulateOptions& options) {
  if (options.samples) change_samples(trajectory, *options.samples);
  if (!options.duration) return;
  try {
    change_duration(trajectory, *options.duration);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--duration ") + error.what());
  }
}

}  // namespace

void add_run_options(CLI::App& parser, SimulateOptions& o) {
  add_spec_options(parser, o.spec);
  parser.add_option("-t,--trajectory", o.trajectory, "trajectory of the spec (default: the first)")->type_name("NAME");
  CLI::Option* output = parser.add_option("-o,--output", o.output, "write the samples to this HDF5 file");
  output->type_name("FILE");
  parser.add_option("--csv", o.csv, "write the samples to this CSV file")->type_name("FILE");
  parser.add_flag("--force", o.force, "overwrite existing files");
  parser.add_flag("--compress", o.compress, "compress the HDF5 file (slow)")->needs(output);
  parser.add_flag("--poses", o.poses, "also write the poses of all bodies");
  parser.add_option("--samples", o.samples, "number of samples, both ends included")
      ->type_name("N")
      ->check(integer_range_validator(trajectory::min_samples, trajectory::max_samples));
  parser.add_option("--duration", o.duration, "duration in seconds")
      ->type_name("T")
      ->check(number_range_validator(trajectory::min_duration, trajectory::max_duration));
  parser.add_option("--about", o.about, "reference point of moments, in metres")->type_name("X,Y[,Z]");
  parser.add_flag("-q,--quiet", o.quiet, "print only errors (and JSON with --json)");
  add_units_option(parser, o.spec.units);
  add_verbose_flag(parser, o.spec.verbose);
}

void add_simulate_options(CLI::App& parser, SimulateOptions& o) {
  add_run_options(parser, o);
  suggest_words(parser.add_option("--formulation", o.formulation, "tree, or natural (a second, independent one)")
                    ->type_name("NAME")
                    ->capture_default_str(),
                formulations());
  CLI::Option* split = parser.add_flag("--split", o.split, "also write the contributions to every torque");
  CLI::Option* orders =
      parser.add_option("--orders", o.orders, "orders of every quantity up to N, for a motion at constant speed")
          ->type_name("N")
          ->check(integer_range_validator(1, max_order));
  parser.add_option("--fluctuation", o.fluctuation, "flywheel for this coefficient of fluctuation of the speed: 0.02")
      ->type_name("CS")
      ->needs(orders)
      ->check(number_range_validator(min_fluctuation, max_fluctuation));
  add_state_options(parser, o.state, "a single state: a pose (A1=0.3,A2=0.5 or tool: [0.1, 0.2]), start or end");
  CLI::Option* at = parser.get_option("--at");
  for (const char* name : {"--samples", "--duration", "--formulation"}) at->excludes(parser.get_option(name));
  at->excludes(split);
  at->excludes(orders);
}

void check_formulation(const SimulateOptions& options, const Study& study) {
  const std::vector<std::string> known = formulations();
  if (std::find(known.begin(), known.end(), options.formulation) == known.end()) {
    throw UsageError(fmt::format("--formulation needs {}, not {}{}", fmt::join(known, " or "),
                                 quote_for_message(options.formulation),
                                 append_nearest_name(options.formulation, known)));
  }
  if (options.formulation == "natural" && study.mechanism.space == SpaceKind::spatial) {
    throw UsageError(study.spec_file + " is spatial: --formulation natural is for planar mechanisms");
  }
}

InverseOptions choose_state_options(const SimulateOptions& options, const Study& study) {
  std::optional<Trajectory> trajectory;
  if (!study.trajectories.empty() || !options.trajectory.empty()) trajectory = choose_trajectory(options, study);
  InverseOptions of_state = dynamics::make_state_options(trajectory ? &*trajectory : nullptr);
  of_state.independent = options.state.independent;
  if (!options.about.empty()) of_state.about = parse_moment_reference(options.about, study.mechanism.space);
  return of_state;
}

Trajectory choose_trajectory(const SimulateOptions& options, const Study& study) {
  Trajectory trajectory = study::choose_trajectory(study, options.trajectory);
  change_timing(trajectory, options);
  if (!options.about.empty()) trajectory.about = parse_moment_reference(options.about, study.mechanism.space);
  return trajectory;
}

void check_outputs(const SimulateOptions& options, const Study& study) {
  if (options.poses && options.output.empty() && options.csv.empty())
    throw UsageError("--poses needs a file to write them to: --output or --csv");
  if (options.split && options.output.empty() && options.csv.empty())
    throw UsageError("--split needs a file to write the contributions to: --output or --csv");
  check_standard_output({options.output, options.csv}, options.spec.json,
                        options.output == files::standard_output_path);
  const std::vector<files::InputFile> inputs = list_input_files(study);
  check_output(options.output, "the result", FileFormat::hdf5, inputs, options.force);
  check_output(options.csv, "the table", FileFormat::csv, inputs, options.force);
  if (!options.output.empty() && !options.csv.empty() && files::is_same_file(options.output, options.csv)) {
    throw UsageError("--output and --csv name the same file: " + options.output);
  }
}

files::SimulateCommand make_simulate_command(const SimulateOptions& options, const Trajectory& trajectory) {
  return {.spec_file = options.spec.spec,
          .trajectory = trajectory.name,
          .samples = options.samples,
          .duration = options.duration,
          .about = options.about,
          .compress = options.compress,
          .poses = options.poses,
          .orders = options.orders,
          .fluctuation = options.fluctuation,
          .split = options.split,
          .formulation = options.formulation};
}

files::Provenance describe(const SimulateOptions& options, const Study& study, const Trajectory& trajectory) {
  return files::make_simulation_provenance(study, trajectory, make_simulate_command(options, trajectory));
}

files::Provenance describe_state(const SimulateOptions& options, const Study& study) {
  return files::describe_state(study, {.spec_file = options.spec.spec,
                                       .at = options.state.at,
                                       .rates = options.state.rates,
                                       .accelerations = options.state.accelerations,
                                       .trajectory = options.trajectory,
                                       .independent = options.state.independent,
                                       .time = options.state.time,
                                       .about = options.about,
                                       .compress = options.compress,
                                       .poses = options.poses});
}

}  // namespace balance::app
