#include "balance/write/law_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace balance {
namespace {

using Dimension = Hdf5Writer::Dimension;

std::span<const double> law_column(const VectorX& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

void add_plane(Hdf5Writer& file, Hdf5Writer::Group group, const PhasePlane& plane) {
  if (plane.time.size() > 0) {
    const Dimension time = file.add_dimension(group, {"time", "time", "s", {}, {}}, law_column(plane.time));
    file.add_variable(group, {"place", "part of the path that is behind", "1", {time}, {}},
                      law_column(plane.path_parameter));
    file.add_variable(group, {"rate", "rate of the place", "1/s", {time}, {}}, law_column(plane.path_rate));
  }
  if (plane.mvc_path_parameter.size() == 0) return;
  const Dimension place = file.add_dimension(group, {"ceiling_place", "part of the path that is behind", "1", {}, {}},
                                             law_column(plane.mvc_path_parameter));
  file.add_variable(group, {"ceiling", "largest rate of the place that the limits leave", "1/s", {place}, {}},
                    law_column(plane.mvc_path_rate));
}

void add_stretches(Hdf5Writer& file, Hdf5Writer::Group group, const std::vector<ActiveLimitInterval>& stretches) {
  if (stretches.empty()) return;
  std::vector<std::string> limits;
  for (const ActiveLimitInterval& stretch : stretches) limits.push_back(stretch.limit.empty() ? "none" : stretch.limit);
  const Dimension limit = file.add_dimension(group, {"limit", "what is at its limit", "1", {}, {}}, limits);
  const auto add = [&](const char* name, const char* long_name, const char* unit, double ActiveLimitInterval::*member) {
    std::vector<double> values;
    for (const ActiveLimitInterval& stretch : stretches) values.push_back(stretch.*member);
    file.add_variable(group, {name, long_name, unit, {limit}, {}}, values);
  };
  add("begin", "when it comes to its limit", "s", &ActiveLimitInterval::begin);
  add("end", "when it leaves its limit", "s", &ActiveLimitInterval::end);
  add("from", "where it comes to its limit", "1", &ActiveLimitInterval::path_begin);
  add("to", "where it leaves its limit", "1", &ActiveLimitInterval::path_end);
}

void add_found(Hdf5Writer& file, Hdf5Writer::Group group, const OptimisedLaw& law) {
  const auto add = [&](const char* name, const char* long_name, const std::string& unit, const double& value) {
    file.add_variable(group, {name, long_name, unit, {}, {}}, std::span(&value, 1));
  };
  add("duration", "duration", "s", law.duration);
  if (law.momentum != 0) add("momentum", "angular momentum that is kept", "N m s", law.momentum);
  if (!law.objective.empty()) {
    add("peak", "least peak of the quantity in the attribute 'of'", law.unit, law.objective_value);
    file.set_attribute(group, "of", law.objective);
  }
  if (!law.switch_times.empty())
    file.add_dimension(group, {"switch", "when the acceleration along the path jumps", "s", {}, {}},
                       std::span(law.switch_times));
  add_stretches(file, group, law.active_limits);
}

}  // namespace

void write_law_group(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result) {
  if (!result.optimised_law && result.phase_plane.mvc_path_rate.size() == 0) return;
  const Hdf5Writer::Group group = file.add_group(parent, "law");
  if (result.optimised_law) add_found(file, group, *result.optimised_law);
  add_plane(file, group, result.phase_plane);
}

}  // namespace balance
