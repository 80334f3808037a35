#include "balance/mechanics/results/metrics.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace balance {

namespace {

/// One row of the run or of what lies between its samples.
struct SampleReference {
  double time;
  const RunResult* result;
  long row;
};

std::vector<SampleReference> merge_in_time_order(const RunResult& result, const IntermediateSamples& between) {
  std::vector<SampleReference> places;
  places.reserve(static_cast<std::size_t>(result.time.size()) + between.next_sample.size());
  std::size_t j = 0;
  for (long k = 0; k < result.time.size(); ++k) {
    for (; j < between.next_sample.size() && between.next_sample[j] == k; ++j) {
      const long row = static_cast<long>(j);
      places.push_back({between.rows.time[row], &between.rows, row});
    }
    places.push_back({result.time[k], &result, k});
  }
  return places;
}

/// Every second place, but both ends and both sides of every jump.
std::vector<SampleReference> halve_samples(const std::vector<SampleReference>& places) {
  std::vector<SampleReference> chosen{places.front()};
  bool skip = true;
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    const double time = places[i].time;
    const bool jump = time == places[i - 1].time || time == places[i + 1].time;
    if (jump || !skip) chosen.push_back(places[i]);
    if (!jump) skip = !skip;
  }
  chosen.push_back(places.back());
  return chosen;
}

/// A scalar with its sign, or a vector's magnitude, at every place.
std::vector<double> evaluate_series(const MetricSeries& track, const std::vector<SampleReference>& places) {
  std::vector<double> all(places.size());
  const auto begin_of = [&](const RunResult* result) { return (result->*track.array).data() + track.first; };
  const RunResult* result = places.front().result;
  const double* first = begin_of(result);
  const long width = (result->*track.array).cols();
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].result != result) first = begin_of(result = places[i].result);
    const double* at = first + places[i].row * width;
    double squares = at[0] * at[0];
    for (int k = 1; k < track.count; ++k) squares += at[k] * at[k];
    all[i] = track.count == 1 ? at[0] : std::sqrt(squares);
  }
  return all;
}

void zero_round_off(Metric& metric, double start) {
  if (metric.peak <= metric.round_off) metric.peak_time = start;
  for (double Metric::*figure : {&Metric::peak, &Metric::rms, &Metric::mean, &Metric::range})
    metric.*figure = suppress_round_off(metric.round_off, metric.*figure);
}

Metric compute_metric(const MetricSeries& track, const std::vector<SampleReference>& places) {
  Metric metric{track.quantity, track.unit};
  const std::vector<double> all = evaluate_series(track, places);
  double peak = 0, low = INFINITY, high = -INFINITY, squares = 0, sum = 0, last = 0, last_square = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double size = std::abs(all[i]), square = size * size;
    peak = std::max(peak, size);
    low = std::min(low, all[i]), high = std::max(high, all[i]);
    if (i > 0) {
      const double half = (places[i].time - places[i - 1].time) / 2;
      squares += half * (square + last_square);
      sum += half * (size + last);
    }
    last = size, last_square = square;
  }
  metric.peak = peak;
  // of peaks that differ by round-off only, the first
  const auto first_peak =
      std::find_if(all.begin(), all.end(), [&](double value) { return std::abs(value) >= (1 - 1e-10) * metric.peak; });
  const bool found = first_peak != all.end();  // else nothing is a number
  metric.peak_time = places[found ? static_cast<std::size_t>(first_peak - all.begin()) : 0].time;
  const double duration = places.back().time - places.front().time;
  metric.rms = std::sqrt(squares / duration);
  metric.mean = sum / duration;
  metric.range = high - low;
  metric.round_off = column_round_off(*places.back().result, track.array, track.first);
  zero_round_off(metric, places.front().time);
  return metric;
}

Metric worst_of(const std::vector<Metric>& all, std::string quantity) {
  Metric worst =
      *std::max_element(all.begin(), all.end(), [](const Metric& a, const Metric& b) { return a.peak < b.peak; });
  worst.quantity = std::move(quantity);
  for (const Metric& metric : all) {
    worst.rms = std::max(worst.rms, metric.rms);
    worst.mean = std::max(worst.mean, metric.mean);
    worst.range = std::max(worst.range, metric.range);
    worst.round_off = std::max(worst.round_off, metric.round_off);
  }
  return worst;
}

double integrate_power(const RunResult& result, const std::vector<SampleReference>& places) {
  double sum = 0;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const auto total = [&](const SampleReference& place) {
      return place.result->power.row(place.row).cwiseAbs().sum();
    };
    sum += (places[i].time - places[i - 1].time) * (total(places[i]) + total(places[i - 1])) / 2;
  }
  if (result.actuator_names.empty()) return 0;
  double round_off = 0;
  for (Eigen::Index a = 0; a < result.power.cols(); ++a) round_off += column_round_off(result, &RunResult::power, a);
  return suppress_round_off(round_off * (places.back().time - places.front().time), sum);
}

/// It shows first that places are too few: what the motors and the frame feel.
bool is_sampling_indicator(const MetricSeries& track) {
  return track.array == &RunResult::torque || track.array == &RunResult::shaking_force ||
         track.array == &RunResult::shaking_moment;
}

/// The largest turn of a joint from one place to the next [rad], and whose.
std::pair<std::string, double> find_largest_joint_step(const RunResult& result,
                                                       const std::vector<SampleReference>& places) {
  std::pair<std::string, double> largest{"", 0};
  const auto position = [&](const SampleReference& place, Eigen::Index c) {
    return place.result->joint_position(place.row, c);
  };
  for (std::size_t joint = 0; joint < result.coordinate_names.size(); ++joint) {
    if (result.coordinate_units[joint] != "rad") continue;
    const auto c = static_cast<Eigen::Index>(joint);
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double turn = std::abs(position(places[i], c) - position(places[i - 1], c));
      if (turn > largest.second) largest = {result.coordinate_names[joint], turn};
    }
  }
  return largest;
}

}  // namespace

std::string check_sampling_density(const RunResult& result, const IntermediateSamples& between) {
  constexpr double max_relative_change = 0.02;
  constexpr double max_joint_step = 0.5;  // rad: the peak of what a turn makes once may then be missed by 3 %
  const std::vector<SampleReference> places = merge_in_time_order(result, between), half = halve_samples(places);
  if (const auto [joint, angle] = find_largest_joint_step(result, places); angle > max_joint_step) {
    char degrees[32];
    std::snprintf(degrees, sizeof degrees, "%.3g", angle * 180 / std::numbers::pi);
    return "figures rest on places that are far apart: " + joint + " turns by " + degrees +
           " degrees from one to the next; ask for more samples";
  }
  if (half.size() < 3) return "";
  for (const MetricSeries& track : list_metric_series(result)) {
    const auto fine = std::find_if(result.metrics.begin(), result.metrics.end(),
                                   [&](const Metric& metric) { return metric.quantity == track.quantity; });
    // of what is nearly round-off every digit changes
    if (!is_sampling_indicator(track) || fine == result.metrics.end() || !(fine->peak > 1e3 * fine->round_off))
      continue;
    const Metric coarse = compute_metric(track, half);
    const double change = std::max(std::abs(fine->peak - coarse.peak), std::abs(fine->rms - coarse.rms));
    if (change > max_relative_change * fine->peak)
      return std::to_string(places.size()) +
             " places along the motion are few for its figures: without every second one " + fine->quantity +
             " would change by " + std::to_string(static_cast<int>(std::lround(100 * change / fine->peak))) +
             " %; ask for more samples";
  }
  return "";
}

void add_metrics(RunResult& result, const IntermediateSamples& between) {
  const std::vector<SampleReference> places = merge_in_time_order(result, between);
  result.metrics.clear();
  const std::vector<MetricSeries> tracks = list_metric_series(result);
  for (const auto& [first, last] : group_metric_series(tracks)) {
    std::vector<Metric> each;
    for (std::size_t i = first; i < last; ++i) each.push_back(compute_metric(tracks[i], places));
    if (!tracks[first].worst_group.empty()) result.metrics.push_back(worst_of(each, tracks[first].worst_group));
    result.metrics.insert(result.metrics.end(), each.begin(), each.end());
  }
  result.energy = integrate_power(result, places);
}

double statistic_of(const Metric& metric, Statistic figure) {
  switch (figure) {
    case Statistic::peak: return metric.peak;
    case Statistic::rms: return metric.rms;
    case Statistic::mean: return metric.mean;
    case Statistic::range: return metric.range;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

namespace {

struct Overflow {
  double time = INFINITY;
  std::string what;
};

/// @param rows that are filled
void find_in_quantities(const RunResult& result, long rows, Overflow& first) {
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    const auto filled = quantity.samples->topRows(rows);
    if ((filled.array() - filled.array()).sum() == 0)
      continue;  // a number minus itself is not a number where it is none
    for (long row = 0; row < rows && result.time[row] < first.time; ++row)
      if (!filled.row(row).allFinite()) first = {result.time[row], quantity.name};
  }
}

}  // namespace

std::optional<MotionOutcome> find_overflow(const RunResult& result, const IntermediateSamples& between,
                                           const Mechanism& mechanism) {
  Overflow first;
  find_in_quantities(result, result.time.size(), first);
  find_in_quantities(between.rows, static_cast<long>(between.next_sample.size()), first);
  for (const Metric& metric : result.metrics) {  // squares overflow long before what they are squares of
    const bool finite = std::isfinite(metric.peak) && std::isfinite(metric.rms) && std::isfinite(metric.mean) &&
                        std::isfinite(metric.range);
    if (!finite && metric.peak_time < first.time) first = {metric.peak_time, metric.quantity};
  }
  if (!std::isfinite(result.energy) && first.what.empty()) first = {result.time[0], "the energy moved"};
  if (first.what.empty()) return std::nullopt;
  return make_overflow_outcome(first.time, first.what, mechanism);
}

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
