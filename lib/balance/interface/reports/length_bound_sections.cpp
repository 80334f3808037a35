#include "balance/interface/reports/length_bound_sections.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace balance::reports {
namespace {

/// Relative to the best design; NaN without one.
double relative_gap(const certificate::LengthBound& bound) {
  return std::isinf(bound.best) ? std::numeric_limits<double>::quiet_NaN() : bound.gap();
}

}  // namespace

std::string length_coverage_text(const certificate::LengthBound& bound) {
  if (!bound.reason.empty()) return "";
  std::vector<std::string> special(bound.geometries.begin(), bound.geometries.end());
  const bool has_general = !special.empty() && special.front() == certificate::general_lengths_name;
  if (has_general) special.erase(special.begin());
  std::string text = "the proof covers ";
  text += !has_general              ? join_with_conjunction(special, "and")
          : bound.uncovered.empty() ? "all lengths within the bounds"
                                    : "general lengths within the bounds";
  if (!bound.trajectories.empty())
    text += " with which " + join_with_conjunction(bound.trajectories, "and") + " can be followed";
  if (has_general && !special.empty()) text += ", " + join_with_conjunction(special, "and") + " included";
  if (!bound.uncovered.empty()) text += "; it does not cover " + join_with_conjunction(bound.uncovered, "and");
  for (const std::string& remark : bound.remarks) text += "; " + remark;
  return text;
}

Json length_bound_json(const std::optional<certificate::LengthBound>& bound) {
  if (!bound) return nullptr;
  if (!bound->reason.empty()) return {{"reason", bound->reason}};
  Json progress = Json::array();
  for (const certificate::LengthBoundProgress& one : bound->progress)
    progress.push_back({{"seconds", one.seconds}, {"lower_bound", one.lower_bound}, {"best", one.best}});
  return {{"reason", ""},
          {"lower_bound", bound->lower_bound},
          {"best", bound->best},
          {"unit", bound->unit},
          {"relative_gap", relative_gap(*bound)},
          {"count", bound->count < 0 ? Json(nullptr) : Json(bound->count)},
          {"impossible", bound->is_impossible()},
          {"covers", bound->geometries},
          {"not_covered", bound->uncovered},
          {"coverage", length_coverage_text(*bound)},
          {"boxes", bound->nodes},
          {"progress", std::move(progress)}};
}

void add_length_bound(hdf5::Hdf5Writer& file, const certificate::LengthBound& bound) {
  if (!bound.reason.empty()) return;
  const hdf5::Hdf5Writer::Group group = file.add_group("length_bound");
  file.set_attribute(group, "covers", bound.geometries);
  if (!bound.uncovered.empty()) file.set_attribute(group, "not_covered", bound.uncovered);
  file.set_attribute(group, "impossible", bound.is_impossible() ? "yes" : "no");
  std::vector<double> seconds, lower, best;
  for (const certificate::LengthBoundProgress& one : bound.progress) {
    seconds.push_back(one.seconds);
    lower.push_back(one.lower_bound);
    best.push_back(one.best);
  }
  const std::string unit = bound.unit.empty() ? "mixed" : bound.unit;
  const hdf5::Hdf5Writer::Dimension time =
      file.add_dimension(group, {"seconds", "computing time of the bound", "s", {}, {}}, seconds);
  file.add_variable(group, {"lower_bound", "no design has less", unit, {time}, {}}, std::span<const double>(lower));
  file.add_variable(group, {"best", "best design so far", unit, {time}, {}}, std::span<const double>(best));
  const double gap = relative_gap(bound), boxes = static_cast<double>(bound.nodes);
  file.add_variable(group, {"relative_gap", "best minus lower bound, relative to best", "1", {}, {}},
                    std::span(&gap, 1));
  file.add_variable(group, {"boxes", "boxes of lengths that were bounded", "1", {}, {}}, std::span(&boxes, 1));
}

}  // namespace balance::reports
