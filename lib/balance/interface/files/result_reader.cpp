#include "balance/foundation/base/file_error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/hdf5/hdf5_reader.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace balance::files {

using hdf5::Hdf5Error;
using hdf5::Hdf5Reader;

// Reads the law of motion of a run from its result file.

/// Reads the optimised law and the phase plane, as far as the file has them.
/// @param prefix of the run in the file: "" or "after/cycloid/"
/// @throws Hdf5Error if sizes or numbers are not valid for a law
void read_law_group(const Hdf5Reader& file, const std::string& prefix, RunResult& result);

namespace {

class LawReader {
 public:
  LawReader(const Hdf5Reader& file, const std::string& group) : file_(file), group_(group) {}

  trajectory::PhasePlane plane() const {
    trajectory::PhasePlane plane;
    if (has("time")) {
      plane.time = read_column("time", is_finite);
      plane.path_parameter = read_column("place", is_fraction, plane.time.size());
      plane.path_rate = read_column("rate", is_finite, plane.time.size());
      expect(std::is_sorted(plane.time.begin(), plane.time.end()), "time");
    }
    if (has("ceiling_place")) {
      plane.mvc_path_parameter = read_column("ceiling_place", is_fraction);
      plane.mvc_path_rate = read_column(
          "ceiling", [](double value) { return value >= 0; }, plane.mvc_path_parameter.size());
      expect(std::is_sorted(plane.mvc_path_parameter.begin(), plane.mvc_path_parameter.end()), "ceiling_place");
    }
    return plane;
  }

  std::optional<trajectory::OptimisedLaw> optimised_law() const {
    if (!has("duration")) return std::nullopt;
    trajectory::OptimisedLaw law;
    law.duration = read_number("duration");
    if (has("momentum")) law.momentum = read_number("momentum");
    if (has("peak")) {
      law.objective_value = read_number("peak");
      law.unit = escape_for_terminal(file_.text_attribute(group_ + "/peak", "units").value_or(""));
      law.objective = escape_for_terminal(file_.text_attribute(group_, "of").value_or(""));
    }
    if (has("switch")) {
      const VectorX times = read_column("switch", is_finite);
      law.switch_times.assign(times.begin(), times.end());
    }
    if (has("limit")) read_active_limits(law);
    return law;
  }

 private:
  static bool is_finite(double value) { return std::isfinite(value); }
  static bool is_fraction(double value) { return value >= -1e-9 && value <= 1 + 1e-9; }

  bool has(const char* name) const { return file_.has(group_ + "/" + name); }

  void expect(bool is_valid, const char* name) const {
    if (!is_valid)
      throw Hdf5Error(quote_for_message(group_ + "/" + name) + " is invalid in a law: the file is damaged");
  }

  template <class Predicate>
  VectorX read_column(const char* name, Predicate is_valid, Eigen::Index rows = -1) const {
    const auto dataset = file_.numbers(group_ + "/" + name, 1);
    const auto count = static_cast<Eigen::Index>(dataset.values.size());
    expect((rows < 0 || count == rows) && std::all_of(dataset.values.begin(), dataset.values.end(), is_valid), name);
    return Eigen::Map<const VectorX>(dataset.values.data(), count);
  }

  double read_number(const char* name) const {
    const auto dataset = file_.numbers(group_ + "/" + name, 1);
    expect(dataset.values.size() == 1 && is_finite(dataset.values[0]), name);
    return dataset.values[0];
  }

  void read_active_limits(trajectory::OptimisedLaw& law) const {
    const auto limits = file_.texts(group_ + "/limit");
    const auto count = static_cast<Eigen::Index>(limits.size());
    const VectorX begin = read_column("begin", is_finite, count), end = read_column("end", is_finite, count);
    const VectorX from = read_column("from", is_fraction, count), to = read_column("to", is_fraction, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const std::string& limit = limits[static_cast<std::size_t>(i)];
      law.active_limits.push_back({begin[i], end[i], from[i], to[i], limit == "none" ? "" : limit});
    }
  }

  const Hdf5Reader& file_;
  std::string group_;
};

}  // namespace

void read_law_group(const Hdf5Reader& file, const std::string& prefix, RunResult& result) {
  if (!file.has(prefix + "law")) return;
  const LawReader reader(file, prefix + "law");
  result.optimised_law = reader.optimised_law();
  result.phase_plane = reader.plane();
}

namespace {

constexpr const char* file_convention = "balance-1";
constexpr double max_stored_iterations = 1e9;  // of one sample: fits into an int

struct RunLocationInFile {
  std::string path, group;
};

/// The text after the colon that follows a file's suffix is a group.
RunLocationInFile parse_location(const std::string& name) {
  for (const char* suffix : {".h5:", ".hdf5:", ".nc:"})
    if (const auto at = name.rfind(suffix); at != std::string::npos) {
      const std::size_t colon = name.find(':', at);
      return {name.substr(0, colon), name.substr(colon + 1)};
    }
  return {name, ""};
}

class ResultReader {
 public:
  ResultReader(const Hdf5Reader& file, const std::string& group)
      : file_(file), prefix_(group.empty() ? "" : group + "/") {}

  RunResult result() {
    read_names();
    read_samples();
    read_metrics();
    read_law_group(file_, prefix_, result_);
    result_.outcome.status = MotionStatus::done;
    return std::move(result_);
  }

 private:
  std::vector<std::string> texts(const std::string& name) const {
    return file_.has(prefix_ + name) ? file_.texts(prefix_ + name) : std::vector<std::string>{};
  }

  /// One unit for all labels, or one per label.
  std::vector<std::string> units(const std::string& single, const std::string& dataset, std::size_t labels) const {
    const std::string unit = file_.text_attribute(prefix_ + dataset, "units").value_or("1");
    if (unit != "mixed") return std::vector<std::string>(labels, unit);
    auto label_units = texts(single);
    expect(label_units.size() == labels, single);
    return label_units;
  }

  void read_names() {
    result_.coordinate_names = texts("coordinate");
    result_.joint_names = texts("joint");
    result_.actuator_names = texts("actuator");
    if (!result_.coordinate_names.empty())
      result_.coordinate_units = units("coordinate_unit", "joint_position", result_.coordinate_names.size());
    if (!result_.actuator_names.empty())
      result_.actuator_units = units("actuator_unit", "torque", result_.actuator_names.size());
    result_.constraint_names = texts("constraint");
    if (!result_.constraint_names.empty())
      result_.constraint_units = units("constraint_unit", "constraint_force", result_.constraint_names.size());
    result_.sliding_names = texts("sliding");
    if (!result_.sliding_names.empty())
      result_.sliding_units = units("sliding_unit", "sliding_variable", result_.sliding_names.size());
    if (file_.has(prefix_ + "body")) result_.body_names = texts("body");
    result_.axes = static_cast<int>(texts("axis").size());
    expect(result_.axes == 2 || result_.axes == 3, "axis");
    result_.moment_axes = result_.axes == 2 ? 1 : 3;
  }

  void read_samples() {
    const auto time = file_.numbers(prefix_ + "time", 1);
    expect(!time.values.empty() && are_finite(time.values) && std::is_sorted(time.values.begin(), time.values.end()),
           "time");
    result_.time = Eigen::Map<const VectorX>(time.values.data(), static_cast<Eigen::Index>(time.values.size()));
    for (const Quantity& quantity : list_all_quantities(result_)) {
      const std::string path = prefix_ + quantity.name;
      if (!file_.has(path)) continue;
      const auto dataset = file_.numbers(path);
      const Eigen::Index rows = result_.time.size(), column_count = count_columns(quantity.columns, result_);
      expect(!dataset.sizes.empty() && static_cast<Eigen::Index>(dataset.sizes[0]) == rows &&
                 static_cast<Eigen::Index>(dataset.values.size()) == rows * column_count && are_finite(dataset.values),
             quantity.name);
      result_.*quantity.member = Eigen::Map<const Samples>(dataset.values.data(), rows, column_count);
      if (quantity.has_moment_reference) read_moment_reference(path);
      read_round_off(quantity, path);
    }
    expect(result_.joint_position.size() > 0 || result_.coordinate_names.empty(), "joint_position");
    expect(result_.shaking_force.size() > 0, "shaking_force");
    const std::string iterations = prefix_ + "newton_iterations";
    if (!file_.has(iterations)) return;
    const auto counts = file_.numbers(iterations, 1);
    const auto is_count = [](double value) { return value >= 0 && value <= max_stored_iterations; };
    expect(
        counts.values.size() == time.values.size() && std::all_of(counts.values.begin(), counts.values.end(), is_count),
        "newton_iterations");
    result_.newton_iterations =
        Eigen::Map<const VectorX>(counts.values.data(), static_cast<Eigen::Index>(counts.values.size())).cast<int>();
  }

  /// Files of version 0.1.0 have no round-off.
  void read_round_off(const Quantity& quantity, const std::string& path) {
    VectorX results::TermMagnitudes::*const magnitude = results::term_magnitude_of(quantity.member);
    const auto round_off = file_.numbers_attribute(path, "round_off");
    if (magnitude == nullptr || !round_off) return;
    const auto count = static_cast<Eigen::Index>(round_off->size()),
               column_count = count_columns(quantity.columns, result_);
    const auto is_magnitude = [](double value) { return value >= 0 && std::isfinite(value); };
    expect(count > 0 && column_count % count == 0 && std::all_of(round_off->begin(), round_off->end(), is_magnitude),
           quantity.name);
    result_.round_off.*magnitude = Eigen::Map<const VectorX>(round_off->data(), count);
  }

  void read_moment_reference(const std::string& path) {
    const auto reference = file_.numbers_attribute(path, "about");
    expect(reference && static_cast<int>(reference->size()) == result_.axes && are_finite(*reference), "about");
    for (int i = 0; i < result_.axes; ++i) result_.moment_reference[i] = (*reference)[static_cast<std::size_t>(i)];
  }

  void read_metrics() {
    const auto energy = file_.numbers(prefix_ + "metrics/energy");
    expect(energy.values.size() == 1, "metrics/energy");
    result_.energy = energy.values[0];
    const auto quantities = texts("metrics/quantity"), units = texts("metrics/unit");
    expect(units.size() == quantities.size(), "metrics/unit");
    for (std::size_t i = 0; i < quantities.size(); ++i)  // version 0.1.0 called a slide's force a torque
      result_.metrics.push_back(
          {.quantity = units[i] == "N" ? results::to_force_name(quantities[i]) : quantities[i], .unit = units[i]});
    const auto read_figures = [&](const std::string& name, double Metric::*figure) {
      if (quantities.empty()) return;
      const auto figures = file_.numbers(prefix_ + "metrics/" + name, 1);
      expect(figures.values.size() == quantities.size(), "metrics/" + name);
      for (std::size_t i = 0; i < figures.values.size(); ++i) result_.metrics[i].*figure = figures.values[i];
    };
    read_figures("peak", &Metric::peak);
    read_figures("peak_time", &Metric::peak_time);
    read_figures("rms", &Metric::rms);
    read_figures("mean", &Metric::mean);
    read_figures("range", &Metric::range);
    if (file_.has(prefix_ + "metrics/round_off")) read_figures("round_off", &Metric::round_off);
  }

  static bool are_finite(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  }

  static void expect(bool is_valid, const std::string& name) {
    if (!is_valid) throw Hdf5Error(quote_for_message(name) + " is invalid in a result: the file is damaged");
  }

  const Hdf5Reader& file_;
  std::string prefix_;
  RunResult result_;
};

/// The runs of a design file.
std::vector<std::string> runs_in(const Hdf5Reader& file) {
  std::vector<std::string> runs;
  for (const char* when : {"before", "after"})
    for (const std::string& name : file.groups(when)) runs.push_back(std::string(when) + "/" + name);
  return runs;
}

void check_group(const Hdf5Reader& file, const std::string& group) {
  if (!group.empty() && file.has(group + "/numbers/deviation"))
    throw Hdf5Error(
        quote_for_message(group) +
        " holds the deviations of the file's run (balance tolerance), not a run: the file without it is the run");
  if (group.empty() && file.has("second_rate") && !file.has("shaking_force"))
    throw Hdf5Error("holds equations of motion (balance equations), not a run: balance simulate writes runs");
  if (group.empty() ? file.has("time") : file.has(group + "/time")) return;
  const auto runs = runs_in(file);
  if (runs.empty()) throw Hdf5Error(group.empty() ? "has no run" : "has no group " + quote_for_message(group));
  if (group.empty())
    throw Hdf5Error(fmt::format("is a design with several runs: append one of them, such as :{}", runs.back()));
  throw Hdf5Error(fmt::format("has no run {}, only {}{}", quote_for_message(group), fmt::join(runs, ", "),
                              append_nearest_name(group, runs)));
}

/// The overrides in a command line, for files of 0.1.0, which store them nowhere else.
std::vector<std::pair<std::string, std::string>> parse_overrides(const std::string& command) {
  std::vector<std::string> words(1);
  bool quoted = false;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (c == '\'')
      quoted = !quoted;
    else if (c == '\\' && !quoted && i + 1 < command.size())
      words.back() += command[++i];
    else if (c == ' ' && !quoted)
      words.emplace_back();
    else
      words.back() += c;
  }
  std::vector<std::pair<std::string, std::string>> overrides;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::size_t equals = words[i + 1].find('=');
    if (words[i] == "--set" && equals != std::string::npos)
      overrides.emplace_back(words[i + 1].substr(0, equals), words[i + 1].substr(equals + 1));
  }
  return overrides;
}

std::vector<std::pair<std::string, std::string>> read_overrides(const Hdf5Reader& file,
                                                                const std::string& command_line) {
  const std::vector<std::string> names = file.texts_attribute("", "override_names");
  const std::vector<std::string> values = file.texts_attribute("", "override_values");
  if (names.size() != values.size())
    throw Hdf5Error("attributes 'override_names' and 'override_values' differ in length");
  if (names.empty()) return parse_overrides(command_line);
  std::vector<std::pair<std::string, std::string>> overrides;
  for (std::size_t i = 0; i < names.size(); ++i) overrides.emplace_back(names[i], values[i]);
  return overrides;
}

/// Values of the free numbers in a run of a design file; empty for other files.
VectorX read_free_values(const Hdf5Reader& file, const std::string& group) {
  const char* const name = group.starts_with("after/") ? "value" : "start";
  if (group.empty() || !file.has("free_number") || !file.has(name)) return {};
  const auto numbers = file.numbers(name, 1);
  const bool are_finite =
      std::all_of(numbers.values.begin(), numbers.values.end(), [](double value) { return std::isfinite(value); });
  if (!are_finite) throw Hdf5Error(quote_for_message(name) + " is invalid in a design: the file is damaged");
  return Eigen::Map<const VectorX>(numbers.values.data(), static_cast<Eigen::Index>(numbers.values.size()));
}

StoredRun read_run(const Hdf5Reader& file, const RunLocationInFile& location) {
  if (file.text_attribute("", "Conventions") != file_convention)
    throw Hdf5Error("is not a result of balance: its attribute 'Conventions' is not " + std::string(file_convention));
  check_group(file, location.group);
  const auto read_text = [&](const char* attribute) { return file.text_attribute("", attribute).value_or(""); };
  const auto read_line = [&](const std::string& group, const char* attribute) {
    return escape_for_terminal(file.text_attribute(group, attribute).value_or(""));
  };
  StoredRun run{.path = location.path,
                .group = location.group,
                .title = read_line("", "title"),
                .version = read_line("", "balance_version"),
                .spec_text = read_text("spec"),
                .command_line = read_text("command_line"),
                .trajectory = read_line(location.group, "trajectory"),
                .law = read_line(location.group, "law"),
                .drive = read_line(location.group, "drive"),
                .formulation = read_line(location.group, "formulation"),
                .controller = read_line(location.group, "controller"),
                .controller_type = read_line(location.group, "controller_type"),
                .at = read_line(location.group, "at")};
  run.overrides = read_overrides(file, run.command_line);
  run.free_values = read_free_values(file, location.group);
  if (!run.controller.empty() && read_line(location.group, "status") != "done")
    run.ended_early = read_line(location.group, "reason");
  run.result = ResultReader(file, location.group).result();
  return run;
}

}  // namespace

bool names_result_file(const std::string& name) {
  const std::string path = parse_location(name).path;
  return path.ends_with(".h5") || path.ends_with(".hdf5") || path.ends_with(".nc");
}

StoredRun read_result_file(const std::string& name) {
  const RunLocationInFile location = parse_location(name);
  std::error_code error;
  const auto status = std::filesystem::status(location.path, error);
  if (!std::filesystem::exists(status)) throw FileError(location.path + ": no such file", ENOENT);
  if (std::filesystem::is_directory(status))
    throw FileError(location.path + ": is a folder, not a result file", EISDIR);
  if (!std::filesystem::is_regular_file(status)) throw SystemError(location.path + ": is not a regular file");
  if (::faccessat(AT_FDCWD, location.path.c_str(), R_OK, AT_EACCESS) != 0)
    throw FileError(fmt::format("{}: cannot be read: {}", location.path, std::strerror(errno)), errno);
  try {
    return read_run(Hdf5Reader(location.path), location);
  } catch (const Hdf5Error& failure) {
    throw SystemError(name + ": " + failure.what());
  }
}

StoredRun read_motion_file(const std::string& name) {
  StoredRun file = read_result_file(name);
  if (!file.at.empty())
    throw SystemError(name +
                      " holds a single state, not a run: simulate without --at, along a trajectory, and use that file");
  return file;
}

}  // namespace balance::files
