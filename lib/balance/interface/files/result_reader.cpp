#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/hdf5/hdf5_reader.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace balance {

// The law of motion of a run from its result file.

/// Fills the found law and the phase plane, as far as the file has them.
/// @param prefix of the run in the file: "" or "after/cycloid/"
/// @throws Hdf5Error if sizes or numbers are not those of a law
void read_law_group(const Hdf5Reader& file, const std::string& prefix, RunResult& result);

namespace {

class LawReader {
 public:
  LawReader(const Hdf5Reader& file, const std::string& group) : file_(file), group_(group) {}

  PhasePlane plane() const {
    PhasePlane plane;
    if (has("time")) {
      plane.time = column("time", is_finite);
      plane.path_parameter = column("place", is_part, plane.time.size());
      plane.path_rate = column("rate", is_finite, plane.time.size());
      expect(std::is_sorted(plane.time.begin(), plane.time.end()), "time");
    }
    if (has("ceiling_place")) {
      plane.mvc_path_parameter = column("ceiling_place", is_part);
      plane.mvc_path_rate = column(
          "ceiling", [](double value) { return value >= 0; }, plane.mvc_path_parameter.size());
      expect(std::is_sorted(plane.mvc_path_parameter.begin(), plane.mvc_path_parameter.end()), "ceiling_place");
    }
    return plane;
  }

  std::optional<OptimisedLaw> found() const {
    if (!has("duration")) return std::nullopt;
    OptimisedLaw law;
    law.duration = number("duration");
    if (has("momentum")) law.momentum = number("momentum");
    if (has("peak")) {
      law.objective_value = number("peak");
      law.unit = escape_for_terminal(file_.text_attribute(group_ + "/peak", "units").value_or(""));
      law.objective = escape_for_terminal(file_.text_attribute(group_, "of").value_or(""));
    }
    if (has("switch")) {
      const VectorX times = column("switch", is_finite);
      law.switch_times.assign(times.begin(), times.end());
    }
    if (has("limit")) stretches(law);
    return law;
  }

 private:
  static bool is_finite(double value) { return std::isfinite(value); }
  static bool is_part(double value) { return value >= -1e-9 && value <= 1 + 1e-9; }

  bool has(const char* name) const { return file_.has(group_ + "/" + name); }

  void expect(bool good, const char* name) const {
    if (!good) throw Hdf5Error(quote_for_message(group_ + "/" + name) + " is not as a law has it: the file is damaged");
  }

  template <class Good>
  VectorX column(const char* name, Good good, Eigen::Index rows = -1) const {
    const auto read = file_.numbers(group_ + "/" + name, 1);
    const auto count = static_cast<Eigen::Index>(read.values.size());
    expect((rows < 0 || count == rows) && std::all_of(read.values.begin(), read.values.end(), good), name);
    return Eigen::Map<const VectorX>(read.values.data(), count);
  }

  double number(const char* name) const {
    const auto read = file_.numbers(group_ + "/" + name, 1);
    expect(read.values.size() == 1 && is_finite(read.values[0]), name);
    return read.values[0];
  }

  void stretches(OptimisedLaw& law) const {
    const auto limits = file_.texts(group_ + "/limit");
    const auto count = static_cast<Eigen::Index>(limits.size());
    const VectorX begin = column("begin", is_finite, count), end = column("end", is_finite, count);
    const VectorX from = column("from", is_part, count), to = column("to", is_part, count);
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
  result.optimised_law = reader.found();
  result.phase_plane = reader.plane();
}

namespace {

constexpr const char* file_convention = "balance-1";
constexpr double max_stored_iterations = 1e9;  // of one sample: an int holds them

struct RunLocationInFile {
  std::string path, group;
};

/// What stands behind the colon after a file's suffix is a group.
RunLocationInFile place_of(const std::string& name) {
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
    names();
    samples();
    metrics();
    read_law_group(file_, prefix_, r_);
    r_.outcome.status = MotionStatus::done;
    return std::move(r_);
  }

 private:
  std::vector<std::string> texts(const std::string& name) const {
    return file_.has(prefix_ + name) ? file_.texts(prefix_ + name) : std::vector<std::string>{};
  }

  /// One unit for all labels, or one for each.
  std::vector<std::string> units(const std::string& single, const std::string& of, std::size_t labels) const {
    const std::string unit = file_.text_attribute(prefix_ + of, "units").value_or("1");
    if (unit != "mixed") return std::vector<std::string>(labels, unit);
    auto found = texts(single);
    expect(found.size() == labels, single);
    return found;
  }

  void names() {
    r_.coordinate_names = texts("coordinate");
    r_.joint_names = texts("joint");
    r_.actuator_names = texts("actuator");
    if (!r_.coordinate_names.empty())
      r_.coordinate_units = units("coordinate_unit", "joint_position", r_.coordinate_names.size());
    if (!r_.actuator_names.empty()) r_.actuator_units = units("actuator_unit", "torque", r_.actuator_names.size());
    r_.constraint_names = texts("constraint");
    if (!r_.constraint_names.empty())
      r_.constraint_units = units("constraint_unit", "constraint_force", r_.constraint_names.size());
    r_.sliding_names = texts("sliding");
    if (!r_.sliding_names.empty())
      r_.sliding_units = units("sliding_unit", "sliding_variable", r_.sliding_names.size());
    if (file_.has(prefix_ + "body")) r_.body_names = texts("body");
    r_.axes = static_cast<int>(texts("axis").size());
    expect(r_.axes == 2 || r_.axes == 3, "axis");
    r_.moment_axes = r_.axes == 2 ? 1 : 3;
  }

  void samples() {
    const auto time = file_.numbers(prefix_ + "time", 1);
    expect(!time.values.empty() && are_finite(time.values) && std::is_sorted(time.values.begin(), time.values.end()),
           "time");
    r_.time = Eigen::Map<const VectorX>(time.values.data(), static_cast<Eigen::Index>(time.values.size()));
    for (const Quantity& quantity : list_all_quantities(r_)) {
      const std::string path = prefix_ + quantity.name;
      if (!file_.has(path)) continue;
      const auto found = file_.numbers(path);
      const Eigen::Index rows = r_.time.size(), wide = count_columns(quantity.columns, r_);
      expect(!found.sizes.empty() && static_cast<Eigen::Index>(found.sizes[0]) == rows &&
                 static_cast<Eigen::Index>(found.values.size()) == rows * wide && are_finite(found.values),
             quantity.name);
      r_.*quantity.member = Eigen::Map<const Samples>(found.values.data(), rows, wide);
      if (quantity.has_moment_reference) about(path);
      round_off(quantity, path);
    }
    expect(r_.joint_position.size() > 0 || r_.coordinate_names.empty(), "joint_position");
    expect(r_.shaking_force.size() > 0, "shaking_force");
    const std::string iterations = prefix_ + "newton_iterations";
    if (!file_.has(iterations)) return;
    const auto found = file_.numbers(iterations, 1);
    const auto is_count = [](double value) { return value >= 0 && value <= max_stored_iterations; };
    expect(found.values.size() == time.values.size() && std::all_of(found.values.begin(), found.values.end(), is_count),
           "newton_iterations");
    r_.newton_iterations =
        Eigen::Map<const VectorX>(found.values.data(), static_cast<Eigen::Index>(found.values.size())).cast<int>();
  }

  /// Files of version 0.1.0 have none.
  void round_off(const Quantity& quantity, const std::string& path) {
    VectorX TermMagnitudes::*const size = term_magnitude_of(quantity.member);
    const auto found = file_.numbers_attribute(path, "round_off");
    if (size == nullptr || !found) return;
    const auto count = static_cast<Eigen::Index>(found->size()), wide = count_columns(quantity.columns, r_);
    const auto good = [](double value) { return value >= 0 && std::isfinite(value); };
    expect(count > 0 && wide % count == 0 && std::all_of(found->begin(), found->end(), good), quantity.name);
    r_.round_off.*size = Eigen::Map<const VectorX>(found->data(), count);
  }

  void about(const std::string& path) {
    const auto point = file_.numbers_attribute(path, "about");
    expect(point && static_cast<int>(point->size()) == r_.axes && are_finite(*point), "about");
    for (int i = 0; i < r_.axes; ++i) r_.moment_reference[i] = (*point)[static_cast<std::size_t>(i)];
  }

  void metrics() {
    const auto energy = file_.numbers(prefix_ + "metrics/energy");
    expect(energy.values.size() == 1, "metrics/energy");
    r_.energy = energy.values[0];
    const auto quantities = texts("metrics/quantity"), units = texts("metrics/unit");
    expect(units.size() == quantities.size(), "metrics/unit");
    for (std::size_t i = 0; i < quantities.size(); ++i)  // version 0.1.0 called a slide's force a torque
      r_.metrics.push_back(
          {.quantity = units[i] == "N" ? to_force_name(quantities[i]) : quantities[i], .unit = units[i]});
    const auto read = [&](const std::string& name, double Metric::*figure) {
      if (quantities.empty()) return;
      const auto found = file_.numbers(prefix_ + "metrics/" + name, 1);
      expect(found.values.size() == quantities.size(), "metrics/" + name);
      for (std::size_t i = 0; i < found.values.size(); ++i) r_.metrics[i].*figure = found.values[i];
    };
    read("peak", &Metric::peak);
    read("peak_time", &Metric::peak_time);
    read("rms", &Metric::rms);
    read("mean", &Metric::mean);
    read("range", &Metric::range);
    if (file_.has(prefix_ + "metrics/round_off")) read("round_off", &Metric::round_off);
  }

  static bool are_finite(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  }

  static void expect(bool good, const std::string& name) {
    if (!good) throw Hdf5Error(quote_for_message(name) + " is not as a result has it: the file is damaged");
  }

  const Hdf5Reader& file_;
  std::string prefix_;
  RunResult r_;
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
        " holds how far the file's run is off (balance tolerance), not a run: the run is the file without it");
  if (group.empty() && file.has("second_rate") && !file.has("shaking_force"))
    throw Hdf5Error("holds equations of motion (balance equations), not a run: balance simulate writes runs");
  if (group.empty() ? file.has("time") : file.has(group + "/time")) return;
  const auto runs = runs_in(file);
  if (runs.empty()) throw Hdf5Error(group.empty() ? "has no run" : "has no group " + quote_for_message(group));
  if (group.empty())
    throw Hdf5Error(fmt::format("is a design with several runs: put one of them behind it, such as :{}", runs.back()));
  throw Hdf5Error(fmt::format("has no run {}, only {}{}", quote_for_message(group), fmt::join(runs, ", "),
                              append_nearest_name(group, runs)));
}

/// The overrides in a command line, for files of 0.1.0, which have them nowhere else.
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
  std::vector<std::pair<std::string, std::string>> found;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::size_t equals = words[i + 1].find('=');
    if (words[i] == "--set" && equals != std::string::npos)
      found.emplace_back(words[i + 1].substr(0, equals), words[i + 1].substr(equals + 1));
  }
  return found;
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

StoredRun read_run(const Hdf5Reader& file, const RunLocationInFile& place) {
  if (file.text_attribute("", "Conventions") != file_convention)
    throw Hdf5Error("is no result of balance: its attribute 'Conventions' is not " + std::string(file_convention));
  check_group(file, place.group);
  const auto whole = [&](const char* attribute) { return file.text_attribute("", attribute).value_or(""); };
  const auto line = [&](const std::string& group, const char* attribute) {
    return escape_for_terminal(file.text_attribute(group, attribute).value_or(""));
  };
  StoredRun run{.path = place.path,
                .group = place.group,
                .title = line("", "title"),
                .version = line("", "balance_version"),
                .spec_text = whole("spec"),
                .command_line = whole("command_line"),
                .trajectory = line(place.group, "trajectory"),
                .law = line(place.group, "law"),
                .drive = line(place.group, "drive"),
                .formulation = line(place.group, "formulation"),
                .controller = line(place.group, "controller"),
                .controller_type = line(place.group, "controller_type"),
                .at = line(place.group, "at")};
  run.overrides = read_overrides(file, run.command_line);
  if (!run.controller.empty() && line(place.group, "status") != "done") run.ended_early = line(place.group, "reason");
  run.result = ResultReader(file, place.group).result();
  return run;
}

}  // namespace

bool names_result_file(const std::string& name) {
  const std::string path = place_of(name).path;
  return path.ends_with(".h5") || path.ends_with(".hdf5") || path.ends_with(".nc");
}

StoredRun read_result_file(const std::string& name) {
  const RunLocationInFile place = place_of(name);
  std::error_code error;
  const auto status = std::filesystem::status(place.path, error);
  if (!std::filesystem::exists(status)) throw SystemError(place.path + ": no such file");
  if (std::filesystem::is_directory(status)) throw SystemError(place.path + ": is a folder, not a result file");
  if (!std::filesystem::is_regular_file(status)) throw SystemError(place.path + ": is not a regular file");
  try {
    return read_run(Hdf5Reader(place.path), place);
  } catch (const Hdf5Error& wrong) {
    throw SystemError(name + ": " + wrong.what());
  }
}

StoredRun read_motion_file(const std::string& name) {
  StoredRun file = read_result_file(name);
  if (!file.at.empty())
    throw SystemError(
        name + " holds a single state, not a run: simulate without --at, along a trajectory, and take that file");
  return file;
}

}  // namespace balance
