#include "simulate_options.hpp"

#include "failure.hpp"
#include "suggestion.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/spec/limits.hpp"
#include "balance/write/file_identity.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/run_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace balance::app {
namespace {

/// Numbers between commas; nothing else around them.
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

Vector3 parse_about(const std::string& text, SpaceKind space) {
  const std::size_t axes = space == SpaceKind::planar ? 2 : 3;
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != axes) {
    throw UsageError(fmt::format("--about needs {} in metres, not '{}'", axes == 2 ? "x,y" : "x,y,z", text));
  }
  Vector3 about = Vector3::Zero();
  for (std::size_t i = 0; i < axes; ++i) about[static_cast<Eigen::Index>(i)] = (*numbers)[i];
  return about;
}

std::vector<std::string> formulations() { return {"tree", "natural"}; }

void change_duration(Trajectory& trajectory, double duration) {
  if (!(duration > 0) || !std::isfinite(duration)) throw UsageError("--duration needs a positive number of seconds");
  if (trajectory.law.kind == LawKind::fastest) {
    throw UsageError(fmt::format("--duration does not go with '{}', whose law finds it", trajectory.name));
  }
  if (std::holds_alternative<TablePath>(trajectory.path) && !is_searched(trajectory.law.kind)) {
    throw UsageError(fmt::format("--duration does not go with '{}': its table has its own times", trajectory.name));
  }
  trajectory.duration = duration;
}

}  // namespace

void add_run_options(CLI::App& parser, SimulateOptions& o) {
  add_spec_options(parser, o.spec);
  parser.add_option("-t,--trajectory", o.trajectory, "which trajectory of the spec; the first if not given")
      ->type_name("NAME");
  CLI::Option* output = parser.add_option("-o,--output", o.output, "write the samples to this HDF5 file");
  output->type_name("FILE");
  parser.add_option("--csv", o.csv, "write the samples to this CSV file")->type_name("FILE");
  parser.add_flag("--force", o.force, "replace files that exist");
  parser.add_flag("--compress", o.compress, "compress the HDF5 file; slow")->needs(output);
  parser.add_flag("--poses", o.poses, "write where every body is, too");
  parser.add_option("--samples", o.samples, "number of samples, both ends included")
      ->type_name("N")
      ->check(CLI::Range(2L, most_samples));
  parser.add_option("--duration", o.duration, "duration in seconds")->type_name("T");
  parser.add_option("--about", o.about, "point that moments are about, in metres")->type_name("X,Y[,Z]");
  parser.add_flag("-q,--quiet", o.quiet, "print nothing but errors (and JSON if asked for)");
}

void add_simulate_options(CLI::App& parser, SimulateOptions& o) {
  add_run_options(parser, o);
  suggest_words(parser.add_option("--formulation", o.formulation, "tree, or natural: the second, independent one")
                    ->type_name("NAME")
                    ->capture_default_str(),
                formulations());
  parser.add_flag("--split", o.split, "write what every torque adds up from, too");
}

void check_formulation(const SimulateOptions& options, const Study& study) {
  const std::vector<std::string> known = formulations();
  if (std::find(known.begin(), known.end(), options.formulation) == known.end()) {
    throw UsageError(fmt::format("--formulation needs {}, not {}{}", fmt::join(known, " or "),
                                 in_quotes(options.formulation), nearest_hint(options.formulation, known)));
  }
  if (options.formulation == "natural" && study.mechanism.space == SpaceKind::spatial) {
    throw UsageError(study.spec_file + " is spatial: --formulation natural is for planar mechanisms");
  }
}

Trajectory choose_trajectory(const SimulateOptions& options, const Study& study) {
  if (study.trajectories.empty())
    throw SpecError({.place = {.file = study.spec_file}, .message = "there is no motion to simulate"});
  std::vector<std::string> names;
  const Trajectory* chosen = options.trajectory.empty() ? &study.trajectories.front() : nullptr;
  for (const Trajectory& trajectory : study.trajectories) {
    names.push_back(trajectory.name);
    if (trajectory.name == options.trajectory) chosen = &trajectory;
  }
  if (chosen == nullptr) {
    throw UsageError(fmt::format("{} has no trajectory {}, only {}{}", study.spec_file, in_quotes(options.trajectory),
                                 fmt::join(names, ", "), nearest_hint(options.trajectory, names)));
  }
  Trajectory trajectory = *chosen;
  if (options.samples) trajectory.samples = *options.samples;
  if (options.duration) change_duration(trajectory, *options.duration);
  if (!options.about.empty()) trajectory.about = parse_about(options.about, study.mechanism.space);
  return trajectory;
}

void check_outputs(const SimulateOptions& options, const Study& study) {
  const Existing existing = options.force ? Existing::replace : Existing::keep;
  if (options.poses && options.output.empty() && options.csv.empty())
    throw UsageError("--poses needs a file to write them to: --output or --csv");
  if (options.split && options.output.empty() && options.csv.empty())
    throw UsageError("--split needs a file to write the parts to: --output or --csv");
  check_standard_output({options.output, options.csv}, options.spec.json, options.output == standard_output);
  for (const std::string& file : {options.output, options.csv}) {
    if (file.empty()) continue;
    if (same_file(file, options.spec.spec)) throw UsageError("the result would replace the spec: " + file);
    keep_tables(file, "the result", study);
    check_writable(file, existing);
  }
  if (!options.output.empty() && !options.csv.empty() && same_file(options.output, options.csv)) {
    throw UsageError("--output and --csv name the same file: " + options.output);
  }
}

FileDescription describe(const SimulateOptions& options, const Study& study, const Trajectory& trajectory) {
  return describe_simulation(study, trajectory,
                             {.spec_file = options.spec.spec,
                              .trajectory = trajectory.name,
                              .samples = options.samples,
                              .duration = options.duration,
                              .about = options.about,
                              .set = options.spec.set,
                              .compress = options.compress,
                              .poses = options.poses,
                              .split = options.split,
                              .formulation = options.formulation});
}

}  // namespace balance::app
