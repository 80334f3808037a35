#include "balance/result/tracks.hpp"

#include "balance/result/effort_names.hpp"
#include "balance/result/recorder.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <unordered_set>

namespace balance {
namespace {

using Figures = QuantityDefinition::MetricScope;

using Names = std::unordered_set<std::string_view>;

const std::vector<std::string>& column_owner_names(ColumnKind columns, const RunResult& result) {
  switch (columns) {
    case ColumnKind::coordinate: return result.coordinate_names;
    case ColumnKind::constraint: return result.constraint_names;
    case ColumnKind::sliding: return result.sliding_names;
    case ColumnKind::joint:
    case ColumnKind::joint_axis: return result.joint_names;
    default: return result.actuator_names;
  }
}

/// @param motors the coordinates that tracking is judged by; none: all
void add(const Quantity& quantity, Figures figures, const RunResult& result, const Names& motors,
         std::vector<MetricSeries>& tracks) {
  const int columns = static_cast<int>(quantity.samples->cols());
  if (figures == Figures::whole) {
    tracks.push_back({quantity.name, quantity.units.front(), quantity.member, 0, columns, ""});
    return;
  }
  const std::vector<std::string>& names = column_owner_names(quantity.columns, result);
  const int width = columns / static_cast<int>(names.size());
  const auto first = static_cast<std::ptrdiff_t>(tracks.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (figures == Figures::tracked && !motors.empty() && !motors.contains(names[i])) continue;
    const std::string& unit = quantity.unit_of(i, names.size());
    tracks.push_back({effort_display_name(quantity.name, unit) + "[" + names[i] + "]", unit, quantity.member,
                      static_cast<int>(i) * width, width});
  }
  // The worst of torques and forces together would have no unit.
  const auto begin = tracks.begin() + first;
  const bool alike =
      std::all_of(begin, tracks.end(), [&](const MetricSeries& track) { return track.unit == begin->unit; });
  if (figures != Figures::per_member && alike)
    for (auto track = begin; track != tracks.end(); ++track) track->worst_group = quantity.name;
}

bool is_control_quantity(Availability occasion) {
  constexpr std::array all = {Availability::control, Availability::tracking, Availability::tool_tracking};
  return std::find(all.begin(), all.end(), occasion) != all.end();
}

}  // namespace

std::vector<MetricSeries> list_metric_series(const RunResult& result) {
  const std::vector<Quantity> quantities = list_all_quantities(result);
  const Names motors(result.actuator_names.begin(), result.actuator_names.end());
  std::vector<MetricSeries> tracks;
  for (const bool control : {true, false})
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      const QuantityDefinition& kind = quantity_table()[q];
      if (is_control_quantity(kind.occasion) == control && kind.figures != Figures::none &&
          quantities[q].samples->cols() > 0)
        add(quantities[q], kind.figures, result, motors, tracks);
    }
  return tracks;
}

std::vector<std::pair<std::size_t, std::size_t>> group_metric_series(const std::vector<MetricSeries>& tracks) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const bool goes_on = i > 0 && !tracks[i].worst_group.empty() && tracks[i].worst_group == tracks[i - 1].worst_group;
    if (goes_on)
      runs.back().second = i + 1;
    else
      runs.emplace_back(i, i + 1);
  }
  return runs;
}

namespace {

std::vector<MetricSeries> tracks_of(const Mechanism& mechanism) {
  RunResult shape;
  name_columns(mechanism, shape);
  resize_arrays(mechanism, 1, {}, shape);
  return list_metric_series(shape);
}

}  // namespace

std::vector<std::string> list_metric_names(const Mechanism& mechanism) {
  const std::vector<MetricSeries> tracks = tracks_of(mechanism);
  std::vector<std::string> names;
  for (const auto& [first, last] : group_metric_series(tracks)) {
    if (!tracks[first].worst_group.empty()) names.push_back(tracks[first].worst_group);
    for (std::size_t i = first; i < last; ++i) names.push_back(tracks[i].quantity);
  }
  return names;
}

std::string find_metric_unit(const Mechanism& mechanism, const std::string& name) {
  for (const MetricSeries& track : tracks_of(mechanism))
    if (is_quantity_name(name, track.quantity) || (!track.worst_group.empty() && track.worst_group == name))
      return track.unit;
  return "";
}

}  // namespace balance
