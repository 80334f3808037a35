#include "balance/interface/reports/length_bound_sections.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/report_fields.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

namespace balance::reports {
namespace {

/// Relative to the best design; NaN without one.
double relative_gap(const certificate::LengthBound& bound) {
  return std::isinf(bound.best) ? std::numeric_limits<double>::quiet_NaN() : bound.gap();
}

const ReportFields<certificate::LengthBoundProgress>& progress_fields() {
  using Row = certificate::LengthBoundProgress;
  static const ReportFields<Row> fields{
      {&Row::seconds, JsonKey{"seconds"}, SiUnit{"s"}, Hdf5Dataset{"computing time of the bound"}},
      {&Row::lower_bound, JsonKey{"lower_bound"}, Hdf5Dataset{"no design has less"}},
      {&Row::best, JsonKey{"best"}, Hdf5Dataset{"best design so far"}}};
  return fields;
}

const ReportFields<certificate::LengthBound>& bound_fields() {
  using Row = certificate::LengthBound;
  static const ReportFields<Row> fields{
      {&Row::reason, JsonKey{"reason"}},
      {&Row::lower_bound, JsonKey{"lower_bound"}},
      {&Row::best, JsonKey{"best"}},
      {&Row::unit, JsonKey{"unit"}},
      {relative_gap, JsonKey{"relative_gap"}, SiUnit{"1"}, Hdf5Dataset{"best minus lower bound, relative to best"}},
      {[](const Row& bound) { return bound.count < 0 ? Json() : Json(bound.count); }, JsonKey{"count"}},
      {&Row::is_impossible, JsonKey{"impossible"}},
      {&Row::geometries, JsonKey{"covers"}},
      {&Row::uncovered, JsonKey{"not_covered"}},
      {length_coverage_text, JsonKey{"coverage"}},
      {&Row::nodes, JsonKey{"boxes"}, SiUnit{"1"}, Hdf5Dataset{"boxes of lengths that were bounded"}},
      {[](const Row& bound) { return rows_json(bound.progress, progress_fields()); }, JsonKey{"progress"}}};
  return fields;
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
  return fields_json(*bound, bound_fields());
}

void add_length_bound(hdf5::Hdf5Writer& file, const certificate::LengthBound& bound) {
  if (!bound.reason.empty()) return;
  const hdf5::Hdf5Writer::Group group = file.add_group("length_bound");
  file.set_attribute(group, "covers", bound.geometries);
  if (!bound.uncovered.empty()) file.set_attribute(group, "not_covered", bound.uncovered);
  file.set_attribute(group, "impossible", bound.is_impossible() ? "yes" : "no");
  file.set_attribute(group, "coverage", length_coverage_text(bound));
  if (bound.count >= 0) file.set_attribute(group, "count", std::to_string(bound.count));
  write_rows(file, group, bound.progress, progress_fields(), bound.unit.empty() ? "mixed" : bound.unit);
  write_fields(file, group, bound, bound_fields());
}

}  // namespace balance::reports
