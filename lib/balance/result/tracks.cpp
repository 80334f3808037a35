#include "balance/result/tracks.hpp"

#include "balance/result/recorder.hpp"

#include <algorithm>
#include <array>

namespace balance {
namespace {

using Figures = QuantityKind::Figures;

/// The coordinates that tracking is judged by: the actuated ones, or all if nothing is actuated.
bool is_tracked(const Result& result, const std::string& coordinate) {
  const std::vector<std::string>& motors = result.actuator_names;
  return motors.empty() || std::find(motors.begin(), motors.end(), coordinate) != motors.end();
}

const std::vector<std::string>& owners(Columns columns, const Result& result) {
  switch (columns) {
    case Columns::coordinate: return result.coordinate_names;
    case Columns::sliding: return result.sliding_names;
    case Columns::joint:
    case Columns::joint_axis: return result.joint_names;
    default: return result.actuator_names;
  }
}

void add(const Quantity& quantity, Figures figures, const Result& result, std::vector<Track>& tracks) {
  const int columns = static_cast<int>(quantity.samples->cols());
  if (figures == Figures::whole) {
    tracks.push_back({quantity.name, quantity.units.front(), quantity.member, 0, columns, ""});
    return;
  }
  const std::vector<std::string>& names = owners(quantity.columns, result);
  const int width = columns / static_cast<int>(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (figures == Figures::tracked && !is_tracked(result, names[i])) continue;
    const std::string& unit = quantity.units[quantity.units.size() == names.size() ? i : 0];
    tracks.push_back({quantity.name + "[" + names[i] + "]", unit, quantity.member, static_cast<int>(i) * width, width,
                      figures == Figures::each ? "" : quantity.name});
  }
}

bool of_control(Occasion occasion) {
  constexpr std::array all = {Occasion::control, Occasion::tracking, Occasion::tool_tracking};
  return std::find(all.begin(), all.end(), occasion) != all.end();
}

}  // namespace

std::vector<Track> list_tracks(const Result& result) {
  const std::vector<Quantity> quantities = all_quantities(result);
  std::vector<Track> tracks;
  for (const bool control : {true, false})
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      const QuantityKind& kind = quantity_table()[q];
      if (of_control(kind.occasion) == control && kind.figures != Figures::none && quantities[q].samples->cols() > 0)
        add(quantities[q], kind.figures, result, tracks);
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

bool have_worst(const std::vector<Track>& tracks, std::size_t first, std::size_t last) {
  if (tracks[first].of_worst.empty()) return false;
  return std::all_of(tracks.begin() + static_cast<std::ptrdiff_t>(first),
                     tracks.begin() + static_cast<std::ptrdiff_t>(last),
                     [&](const Track& track) { return track.unit == tracks[first].unit; });
}

std::vector<std::string> figure_names(const Mechanism& mechanism) {
  Result shape;
  name_columns(mechanism, shape);
  size_arrays(mechanism, 1, {}, shape);
  const std::vector<Track> tracks = list_tracks(shape);
  std::vector<std::string> names;
  for (const auto& [first, last] : neighbours(tracks)) {
    if (have_worst(tracks, first, last)) names.push_back(tracks[first].of_worst);
    for (std::size_t i = first; i < last; ++i) names.push_back(tracks[i].quantity);
  }
  return names;
}

}  // namespace balance
