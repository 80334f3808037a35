#include "balance/result/metrics.hpp"

#include "balance/result/round_off.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <utility>

namespace balance {

namespace {

/// One row of the run or of what lies between its samples.
struct Place {
  double time;
  const Result* result;
  long row;
};

std::vector<Place> in_order(const Result& result, const BetweenSamples& between) {
  std::vector<Place> places;
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
std::vector<Place> every_second(const std::vector<Place>& places) {
  std::vector<Place> chosen{places.front()};
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

/// Columns of one of Result's arrays that together are one quantity.
struct Track {
  Samples Result::*array;
  int first, count;

  double magnitude(const Place& place) const {
    const auto row = (place.result->*array).row(place.row).segment(first, count);
    return count == 1 ? std::abs(row[0]) : row.norm();
  }
  double round_off(const Result& result) const { return round_off_of(result, array, first); }
  double value(const Place& place) const {
    return count == 1 ? (place.result->*array)(place.row, first) : magnitude(place);
  }
};

void drop_round_off(Metric& metric, double start) {
  if (metric.peak <= metric.round_off) metric.peak_time = start;
  for (double Metric::*figure : {&Metric::peak, &Metric::rms, &Metric::mean, &Metric::range})
    metric.*figure = above(metric.round_off, metric.*figure);
}

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
  metric.peak_time = first_peak == places.end() ? places.front().time : first_peak->time;  // end: nothing is a number
  const double duration = places.back().time - places.front().time;
  metric.rms = std::sqrt(squares / duration);
  metric.mean = sum / duration;
  metric.range = high - low;
  metric.round_off = series.round_off(*places.back().result);
  drop_round_off(metric, places.front().time);
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
  if (result.torque_variation.size() == 0) return;
  if (result.tracking_error.size() > 0)
    add_each(result, "tracking_error", &Result::tracking_error, result.coordinate_names, result.coordinate_units,
             tracked(result), places);
  if (result.tool_error.size() > 0) {
    result.metrics.push_back(measure("tool_error", "m", {&Result::tool_error, 0, result.axes}, places));
    result.metrics.push_back(measure("tool_angle_error", "rad", {&Result::tool_angle_error, 0, 1}, places));
  }
  if (result.sliding_variable.size() > 0)
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
  if (result.actuator_names.empty()) return 0;
  double round_off = 0;
  for (Eigen::Index a = 0; a < result.power.cols(); ++a) round_off += round_off_of(result, &Result::power, a);
  return above(round_off * (places.back().time - places.front().time), sum);
}

/// Quantities that show first that places are too few: what the motors and the frame feel.
std::vector<Metric> telling_figures(const Result& result, const std::vector<Place>& places) {
  std::vector<Metric> all;
  for (std::size_t a = 0; a < result.actuator_names.size(); ++a)
    all.push_back(measure("torque[" + result.actuator_names[a] + "]", result.actuator_units[a],
                          {&Result::torque, static_cast<int>(a), 1}, places));
  all.push_back(measure("shaking_force", "N", {&Result::shaking_force, 0, result.axes}, places));
  all.push_back(measure("shaking_moment", "N m", {&Result::shaking_moment, 0, result.moment_axes}, places));
  return all;
}

/// The largest turn of a joint from one place to the next [rad], and whose.
std::pair<std::string, double> largest_turn(const Result& result, const std::vector<Place>& places) {
  std::pair<std::string, double> largest{"", 0};
  const auto position = [&](const Place& place, Eigen::Index c) { return place.result->joint_position(place.row, c); };
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

std::string sampling_note(const Result& result, const BetweenSamples& between) {
  constexpr double much = 0.02;
  constexpr double far = 0.5;  // rad: the peak of what a turn makes once may then be missed by 3 %
  const std::vector<Place> places = in_order(result, between), half = every_second(places);
  if (const auto [joint, angle] = largest_turn(result, places); angle > far) {
    char degrees[32];
    std::snprintf(degrees, sizeof degrees, "%.3g", angle * 180 / std::numbers::pi);
    return "figures rest on places that are far apart: " + joint + " turns by " + degrees +
           " degrees from one to the next; ask for more samples";
  }
  if (half.size() < 3) return "";
  const std::vector<Metric> fine = telling_figures(result, places), coarse = telling_figures(result, half);
  for (std::size_t i = 0; i < fine.size(); ++i) {
    const double change = std::max(std::abs(fine[i].peak - coarse[i].peak), std::abs(fine[i].rms - coarse[i].rms));
    const bool counts = fine[i].peak > 1e3 * fine[i].round_off;  // of what is nearly round-off every digit changes
    if (counts && change > much * fine[i].peak)
      return std::to_string(places.size()) +
             " places along the motion are few for its figures: without every second one " + fine[i].quantity +
             " would change by " + std::to_string(static_cast<int>(std::lround(100 * change / fine[i].peak))) +
             " %; ask for more samples";
  }
  return "";
}

void add_metrics(Result& result, const BetweenSamples& between) {
  const std::vector<Place> places = in_order(result, between);
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
