#include "balance/result/tracks.hpp"

#include "balance/result/effort_names.hpp"
#include "balance/result/recorder.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <unordered_set>

namespace balance {
namespace {

using Figures = QuantityKind::Figures;

using Names = std::unordered_set<std::string_view>;

const std::vector<std::string>& owners(Columns columns, const Result& result) {
  switch (columns) {
    case Columns::coordinate: return result.coordinate_names;
    case Columns::constraint: return result.constraint_names;
    case Columns::sliding: return result.sliding_names;
    case Columns::joint:
    case Columns::joint_axis: return result.joint_names;
    default: return result.actuator_names;
  }
}

/// @param motors the coordinates that tracking is judged by; none: all
void add(const Quantity& quantity, Figures figures, const Result& result, const Names& motors,
         std::vector<Track>& tracks) {
  const int columns = static_cast<int>(quantity.samples->cols());
  if (figures == Figures::whole) {
    tracks.push_back({quantity.name, quantity.units.front(), quantity.member, 0, columns, ""});
    return;
  }
  const std::vector<std::string>& names = owners(quantity.columns, result);
  const int width = columns / static_cast<int>(names.size());
  const auto first = static_cast<std::ptrdiff_t>(tracks.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (figures == Figures::tracked && !motors.empty() && !motors.contains(names[i])) continue;
    const std::string& unit = quantity.unit_of(i, names.size());
    tracks.push_back({effort_name(quantity.name, unit) + "[" + names[i] + "]", unit, quantity.member,
                      static_cast<int>(i) * width, width});
  }
  // The worst of torques and forces together would have no unit.
  const auto begin = tracks.begin() + first;
  const bool alike = std::all_of(begin, tracks.end(), [&](const Track& track) { return track.unit == begin->unit; });
  if (figures != Figures::each && alike)
    for (auto track = begin; track != tracks.end(); ++track) track->of_worst = quantity.name;
}

bool of_control(Occasion occasion) {
  constexpr std::array all = {Occasion::control, Occasion::tracking, Occasion::tool_tracking};
  return std::find(all.begin(), all.end(), occasion) != all.end();
}

}  // namespace

std::vector<Track> list_tracks(const Result& result) {
  const std::vector<Quantity> quantities = all_quantities(result);
  const Names motors(result.actuator_names.begin(), result.actuator_names.end());
  std::vector<Track> tracks;
  for (const bool control : {true, false})
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      const QuantityKind& kind = quantity_table()[q];
      if (of_control(kind.occasion) == control && kind.figures != Figures::none && quantities[q].samples->cols() > 0)
        add(quantities[q], kind.figures, result, motors, tracks);
    }
  return tracks;
}

std::vector<std::pair<std::size_t, std::size_t>> neighbours(const std::vector<Track>& tracks) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const bool goes_on = i > 0 && !tracks[i].of_worst.empty() && tracks[i].of_worst == tracks[i - 1].of_worst;
    if (goes_on)
      runs.back().second = i + 1;
    else
      runs.emplace_back(i, i + 1);
  }
  return runs;
}

namespace {

std::vector<Track> tracks_of(const Mechanism& mechanism) {
  Result shape;
  name_columns(mechanism, shape);
  size_arrays(mechanism, 1, {}, shape);
  return list_tracks(shape);
}

}  // namespace

std::vector<std::string> figure_names(const Mechanism& mechanism) {
  const std::vector<Track> tracks = tracks_of(mechanism);
  std::vector<std::string> names;
  for (const auto& [first, last] : neighbours(tracks)) {
    if (!tracks[first].of_worst.empty()) names.push_back(tracks[first].of_worst);
    for (std::size_t i = first; i < last; ++i) names.push_back(tracks[i].quantity);
  }
  return names;
}

std::string figure_unit(const Mechanism& mechanism, const std::string& name) {
  for (const Track& track : tracks_of(mechanism))
    if (is_name_of(name, track.quantity) || (!track.of_worst.empty() && track.of_worst == name)) return track.unit;
  return "";
}

}  // namespace balance
