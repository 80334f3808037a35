#include "balance/read/law_group.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace balance {
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

}  // namespace balance
