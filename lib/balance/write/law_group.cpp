#include "balance/write/law_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace balance {
namespace {

using Dimension = Hdf5File::Dimension;

std::span<const double> law_column(const VectorX& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

void add_plane(Hdf5File& file, Hdf5File::Group group, const PhasePlane& plane) {
  if (plane.time.size() > 0) {
    const Dimension time = file.add_dimension(group, {"time", "time", "s", {}, {}}, law_column(plane.time));
    file.add(group, {"place", "part of the path that is behind", "1", {time}, {}}, law_column(plane.place));
    file.add(group, {"rate", "rate of the place", "1/s", {time}, {}}, law_column(plane.rate));
  }
  if (plane.ceiling_place.size() == 0) return;
  const Dimension place = file.add_dimension(group, {"ceiling_place", "part of the path that is behind", "1", {}, {}},
                                             law_column(plane.ceiling_place));
  file.add(group, {"ceiling", "largest rate of the place that the limits leave", "1/s", {place}, {}},
           law_column(plane.ceiling));
}

void add_stretches(Hdf5File& file, Hdf5File::Group group, const std::vector<LawStretch>& stretches) {
  if (stretches.empty()) return;
  std::vector<std::string> limits;
  for (const LawStretch& stretch : stretches) limits.push_back(stretch.limit.empty() ? "none" : stretch.limit);
  const Dimension limit = file.add_dimension(group, {"limit", "what is at its limit", "1", {}, {}}, limits);
  const auto add = [&](const char* name, const char* long_name, const char* unit, double LawStretch::*member) {
    std::vector<double> values;
    for (const LawStretch& stretch : stretches) values.push_back(stretch.*member);
    file.add(group, {name, long_name, unit, {limit}, {}}, values);
  };
  add("begin", "when it comes to its limit", "s", &LawStretch::begin);
  add("end", "when it leaves its limit", "s", &LawStretch::end);
  add("from", "where it comes to its limit", "1", &LawStretch::from);
  add("to", "where it leaves its limit", "1", &LawStretch::to);
}

void add_found(Hdf5File& file, Hdf5File::Group group, const FoundLaw& law) {
  const auto add = [&](const char* name, const char* long_name, const std::string& unit, const double& value) {
    file.add(group, {name, long_name, unit, {}, {}}, std::span(&value, 1));
  };
  add("duration", "duration", "s", law.duration);
  if (law.momentum != 0) add("momentum", "angular momentum that is kept", "N m s", law.momentum);
  if (!law.of.empty()) {
    add("peak", "least peak of the quantity in the attribute 'of'", law.unit, law.peak);
    file.set_attribute(group, "of", law.of);
  }
  if (!law.switches.empty())
    file.add_dimension(group, {"switch", "when the acceleration along the path jumps", "s", {}, {}},
                       std::span(law.switches));
  add_stretches(file, group, law.stretches);
}

}  // namespace

void add_law(Hdf5File& file, Hdf5File::Group parent, const Result& result) {
  if (!result.found_law && result.phase_plane.ceiling.size() == 0) return;
  const Hdf5File::Group group = file.add_group(parent, "law");
  if (result.found_law) add_found(file, group, *result.found_law);
  add_plane(file, group, result.phase_plane);
}

}  // namespace balance
