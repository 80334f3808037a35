#include "balance/study/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace balance {

namespace {

/// One row of the run or of a jump's side, in the order of time.
struct Place {
  double time;
  const Result* result;
  long row;
};

std::vector<Place> in_order(const Result& result, const Jumps& jumps) {
  std::vector<Place> places;
  places.reserve(static_cast<std::size_t>(result.time.size()) + 2 * jumps.next_sample.size());
  std::size_t j = 0;
  for (long k = 0; k < result.time.size(); ++k) {
    for (; j < jumps.next_sample.size() && jumps.next_sample[j] == k; ++j) {
      const long before = 2 * static_cast<long>(j);
      places.push_back({jumps.sides.time[before], &jumps.sides, before});
      if (!jumps.on_sample[j]) places.push_back({jumps.sides.time[before + 1], &jumps.sides, before + 1});
    }
    places.push_back({result.time[k], &result, k});
  }
  return places;
}

/// Columns of one of Result's arrays that together are one quantity.
struct Track {
  Samples Result::*array;
  int first, count;

  double magnitude(const Place& place) const {
    const auto row = (place.result->*array).row(place.row).segment(first, count);
    return count == 1 ? std::abs(row[0]) : row.norm();
  }
  double value(const Place& place) const {
    return count == 1 ? (place.result->*array)(place.row, first) : magnitude(place);
  }
};

Metric measure(std::string quantity, std::string unit, const Track& series, const std::vector<Place>& places) {
  Metric metric{std::move(quantity), std::move(unit)};
  double low = INFINITY, high = -INFINITY, squares = 0, sum = 0, last = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double magnitude = series.magnitude(places[i]), value = series.value(places[i]);
    metric.peak = std::max(metric.peak, magnitude);
    low = std::min(low, value), high = std::max(high, value);
    if (i > 0) {
      const double step = places[i].time - places[i - 1].time;
      squares += step * (magnitude * magnitude + last * last) / 2;
      sum += step * (magnitude + last) / 2;
    }
    last = magnitude;
  }
  // of peaks that differ by round-off only, the first
  const auto first_peak = std::find_if(places.begin(), places.end(), [&](const Place& place) {
    return series.magnitude(place) >= (1 - 1e-10) * metric.peak;
  });
  metric.peak_time = first_peak->time;
  const double duration = places.back().time - places.front().time;
  metric.rms = std::sqrt(squares / duration);
  metric.mean = sum / duration;
  metric.range = high - low;
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
  }
  return worst;
}

/// A metric per actuator, led by the worst of them where their units agree.
void add_actuators(Result& result, const char* name, Samples Result::*array, const std::vector<std::string>& units,
                   const std::vector<Place>& places) {
  std::vector<Metric> each;
  for (std::size_t a = 0; a < result.actuator_names.size(); ++a)
    each.push_back(measure(std::string(name) + "[" + result.actuator_names[a] + "]", units[a],
                           {array, static_cast<int>(a), 1}, places));
  const bool alike = std::all_of(units.begin(), units.end(), [&](const std::string& unit) { return unit == units[0]; });
  if (!each.empty() && alike) result.metrics.push_back(worst_of(each, name));
  result.metrics.insert(result.metrics.end(), each.begin(), each.end());
}

/// Of chosen columns with one quantity each, led by the worst of them where their units agree.
void add_each(Result& result, const std::string& name, Samples Result::*array, const std::vector<std::string>& names,
              const std::vector<std::string>& units, const std::vector<int>& columns,
              const std::vector<Place>& places) {
  std::vector<Metric> each;
  bool alike = true;
  for (const int c : columns) {
    const auto i = static_cast<std::size_t>(c);
    each.push_back(measure(name + "[" + names[i] + "]", units[i], {array, c, 1}, places));
    alike = alike && each.back().unit == each.front().unit;
  }
  if (!each.empty() && alike) result.metrics.push_back(worst_of(each, name));
  result.metrics.insert(result.metrics.end(), each.begin(), each.end());
}

std::vector<int> all_of(const std::vector<std::string>& names) {
  std::vector<int> columns(names.size());
  std::iota(columns.begin(), columns.end(), 0);
  return columns;
}

/// The coordinates that tracking is judged by: the actuated ones, or all if nothing is actuated.
std::vector<int> tracked(const Result& result) {
  std::vector<int> columns;
  for (const std::string& name : result.actuator_names)
    columns.push_back(static_cast<int>(std::find(result.coordinate_names.begin(), result.coordinate_names.end(), name) -
                                       result.coordinate_names.begin()));
  return columns.empty() ? all_of(result.coordinate_names) : columns;
}

void add_control(Result& result, const std::vector<Place>& places) {
  if (result.tracking_error.size() == 0) return;
  add_each(result, "tracking_error", &Result::tracking_error, result.coordinate_names, result.coordinate_units,
           tracked(result), places);
  if (result.tool_error.size() > 0) {
    result.metrics.push_back(measure("tool_error", "m", {&Result::tool_error, 0, result.axes}, places));
    result.metrics.push_back(measure("tool_angle_error", "rad", {&Result::tool_angle_error, 0, 1}, places));
  }
  add_each(result, "sliding_variable", &Result::sliding_variable, result.sliding_names, result.sliding_units,
           all_of(result.sliding_names), places);
  const auto motors = all_of(result.actuator_names);
  add_each(result, "torque_variation", &Result::torque_variation, result.actuator_names, result.actuator_units, motors,
           places);
  add_each(result, "saturation", &Result::saturation, result.actuator_names,
           std::vector<std::string>(motors.size(), "1"), motors, places);
}

double energy(const Result& result, const std::vector<Place>& places) {
  double sum = 0;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const auto total = [&](const Place& place) { return place.result->power.row(place.row).cwiseAbs().sum(); };
    sum += (places[i].time - places[i - 1].time) * (total(places[i]) + total(places[i - 1])) / 2;
  }
  return result.actuator_names.empty() ? 0 : sum;
}

}  // namespace

void add_metrics(Result& result, const Jumps& jumps) {
  const std::vector<Place> places = in_order(result, jumps);
  result.metrics.clear();
  add_control(result, places);
  add_actuators(result, "torque", &Result::torque, result.actuator_units, places);
  add_actuators(result, "power", &Result::power, std::vector<std::string>(result.actuator_names.size(), "W"), places);
  const int axes = result.axes, turns = result.moment_axes;
  const auto add = [&](const char* name, const char* unit, Samples Result::*array, int first, int count) {
    result.metrics.push_back(measure(name, unit, {array, first, count}, places));
  };
  add("shaking_force", "N", &Result::shaking_force, 0, axes);
  add("shaking_moment", "N m", &Result::shaking_moment, 0, turns);
  add("ground_force", "N", &Result::ground_force, 0, axes);
  add("ground_moment", "N m", &Result::ground_moment, 0, turns);
  add("com_velocity", "m/s", &Result::com_velocity, 0, axes);
  add("com_acceleration", "m/s^2", &Result::com_acceleration, 0, axes);
  add("kinetic_energy", "J", &Result::kinetic_energy, 0, 1);
  for (std::size_t j = 0; j < result.joint_names.size() && result.joint_force.size() > 0; ++j) {
    const int k = static_cast<int>(j);
    add(("joint_force[" + result.joint_names[j] + "]").c_str(), "N", &Result::joint_force, k * axes, axes);
    add(("joint_moment[" + result.joint_names[j] + "]").c_str(), "N m", &Result::joint_moment, k * turns, turns);
  }
  result.energy = energy(result, places);
}

}  // namespace balance
