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

namespace balance::results {

namespace {

/// One row of the run or of its intermediate samples.
struct SampleReference {
  double time;
  const RunResult* result;
  long row;
};

std::vector<SampleReference> merge_in_time_order(const RunResult& result, const IntermediateSamples& between) {
  std::vector<SampleReference> samples;
  samples.reserve(static_cast<std::size_t>(result.time.size()) + between.next_sample.size());
  std::size_t j = 0;
  for (long k = 0; k < result.time.size(); ++k) {
    for (; j < between.next_sample.size() && between.next_sample[j] == k; ++j) {
      const long row = static_cast<long>(j);
      samples.push_back({between.rows.time[row], &between.rows, row});
    }
    samples.push_back({result.time[k], &result, k});
  }
  return samples;
}

/// Every second sample, plus both ends and both sides of every jump.
std::vector<SampleReference> halve_samples(const std::vector<SampleReference>& samples) {
  std::vector<SampleReference> chosen{samples.front()};
  bool skip = true;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const double time = samples[i].time;
    const bool jump = time == samples[i - 1].time || time == samples[i + 1].time;
    if (jump || !skip) chosen.push_back(samples[i]);
    if (!jump) skip = !skip;
  }
  chosen.push_back(samples.back());
  return chosen;
}

/// A scalar with its sign, or the magnitude of a vector, at every sample.
std::vector<double> evaluate_series(const MetricSeries& series, const std::vector<SampleReference>& samples) {
  std::vector<double> series_values(samples.size());
  const auto begin_of = [&](const RunResult* result) { return (result->*series.array).data() + series.first; };
  const RunResult* result = samples.front().result;
  const double* first = begin_of(result);
  const long width = (result->*series.array).cols();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].result != result) first = begin_of(result = samples[i].result);
    const double* values = first + samples[i].row * width;
    double squares = values[0] * values[0];
    for (int k = 1; k < series.count; ++k) squares += values[k] * values[k];
    series_values[i] = series.count == 1 ? values[0] : std::sqrt(squares);
  }
  return series_values;
}

void zero_round_off(Metric& metric, double start) {
  if (metric.peak <= metric.round_off) metric.peak_time = start;
  for (double Metric::*statistic :
       {&Metric::peak, &Metric::rms, &Metric::mean, &Metric::range, &Metric::minimum, &Metric::maximum})
    metric.*statistic = suppress_round_off(metric.round_off, metric.*statistic);
}

/// @param time_of time of the i-th value
template <class TimeOf>
Metric summarise(const std::vector<double>& values, const TimeOf& time_of) {
  Metric metric;
  double peak = 0, low = INFINITY, high = -INFINITY, squares = 0, sum = 0, last = 0, last_square = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double size = std::abs(values[i]), square = size * size;
    peak = std::max(peak, size);
    low = std::min(low, values[i]), high = std::max(high, values[i]);
    if (i > 0) {
      const double half_step = (time_of(i) - time_of(i - 1)) / 2;
      squares += half_step * (square + last_square);
      sum += half_step * (size + last);
    }
    last = size, last_square = square;
  }
  metric.peak = peak;
  // among peaks that are equal up to round-off, the first
  const auto first_peak = std::find_if(values.begin(), values.end(),
                                       [&](double value) { return std::abs(value) >= (1 - 1e-10) * metric.peak; });
  const bool is_found = first_peak != values.end();  // otherwise all values are NaN
  metric.peak_time = time_of(is_found ? static_cast<std::size_t>(first_peak - values.begin()) : 0);
  const double duration = time_of(values.size() - 1) - time_of(0);
  metric.rms = std::sqrt(squares / duration);
  metric.mean = sum / duration;
  metric.range = high - low;
  metric.minimum = low, metric.maximum = high;
  return metric;
}

Metric compute_metric(const MetricSeries& series, const std::vector<SampleReference>& samples) {
  Metric metric = summarise(evaluate_series(series, samples), [&](std::size_t i) { return samples[i].time; });
  metric.quantity = series.quantity;
  metric.unit = series.unit;
  metric.round_off = column_round_off(*samples.back().result, series.array, series.first);
  zero_round_off(metric, samples.front().time);
  return metric;
}

Metric find_worst_metric(const std::vector<Metric>& all, std::string quantity) {
  Metric worst =
      *std::max_element(all.begin(), all.end(), [](const Metric& a, const Metric& b) { return a.peak < b.peak; });
  worst.quantity = std::move(quantity);
  for (const Metric& metric : all) {
    worst.rms = std::max(worst.rms, metric.rms);
    worst.mean = std::max(worst.mean, metric.mean);
    worst.range = std::max(worst.range, metric.range);
    worst.minimum = std::min(worst.minimum, metric.minimum);
    worst.maximum = std::max(worst.maximum, metric.maximum);
    worst.round_off = std::max(worst.round_off, metric.round_off);
  }
  return worst;
}

double integrate_power(const RunResult& result, const std::vector<SampleReference>& samples) {
  double sum = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const auto total = [&](const SampleReference& sample) {
      return sample.result->power.row(sample.row).cwiseAbs().sum();
    };
    sum += (samples[i].time - samples[i - 1].time) * (total(samples[i]) + total(samples[i - 1])) / 2;
  }
  if (result.actuator_names.empty()) return 0;
  double round_off = 0;
  for (Eigen::Index a = 0; a < result.power.cols(); ++a) round_off += column_round_off(result, &RunResult::power, a);
  return suppress_round_off(round_off * (samples.back().time - samples.front().time), sum);
}

/// Quantities that first reveal a lack of samples: efforts of the actuators, shaking force and moment.
bool is_sampling_indicator(const MetricSeries& series) {
  return series.array == &RunResult::torque || series.array == &RunResult::shaking_force ||
         series.array == &RunResult::shaking_moment;
}

/// The largest rotation of a joint between consecutive samples [rad], and the joint's coordinate.
std::pair<std::string, double> find_largest_joint_step(const RunResult& result,
                                                       const std::vector<SampleReference>& samples) {
  std::pair<std::string, double> largest{"", 0};
  const auto position = [&](const SampleReference& sample, Eigen::Index c) {
    return sample.result->joint_position(sample.row, c);
  };
  for (std::size_t joint = 0; joint < result.coordinate_names.size(); ++joint) {
    if (result.coordinate_units[joint] != "rad") continue;
    const auto c = static_cast<Eigen::Index>(joint);
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const double rotation = std::abs(position(samples[i], c) - position(samples[i - 1], c));
      if (rotation > largest.second) largest = {result.coordinate_names[joint], rotation};
    }
  }
  return largest;
}

}  // namespace

std::string check_sampling_density(const RunResult& result, const IntermediateSamples& between) {
  constexpr double max_relative_change = 0.02;
  constexpr double max_joint_step = 0.5;  // [rad]; a peak that occurs once per turn may then be missed by 3 %
  const std::vector<SampleReference> samples = merge_in_time_order(result, between),
                                     coarse_samples = halve_samples(samples);
  if (const auto [joint, angle] = find_largest_joint_step(result, samples); angle > max_joint_step) {
    char degrees[32];
    std::snprintf(degrees, sizeof degrees, "%.3g", angle * 180 / std::numbers::pi);
    return "figures rest on samples that are far apart: " + joint + " turns by " + degrees +
           " degrees from one to the next; use more samples";
  }
  if (coarse_samples.size() < 3) return "";
  for (const MetricSeries& series : list_metric_series(result)) {
    const auto full_metric = std::find_if(result.metrics.begin(), result.metrics.end(),
                                          [&](const Metric& metric) { return metric.quantity == series.quantity; });
    // values near round-off change in every digit
    if (!is_sampling_indicator(series) || full_metric == result.metrics.end() ||
        !(full_metric->peak > 1e3 * full_metric->round_off))
      continue;
    const Metric coarse_metric = compute_metric(series, coarse_samples);
    const double change =
        std::max(std::abs(full_metric->peak - coarse_metric.peak), std::abs(full_metric->rms - coarse_metric.rms));
    if (change > max_relative_change * full_metric->peak)
      return std::to_string(samples.size()) +
             " samples are too few for the figures of this motion: without every second one, " + full_metric->quantity +
             " would change by " + std::to_string(static_cast<int>(std::lround(100 * change / full_metric->peak))) +
             " %; use more samples";
  }
  return "";
}

void add_metrics(RunResult& result, const IntermediateSamples& between) {
  const std::vector<SampleReference> samples = merge_in_time_order(result, between);
  result.metrics.clear();
  const std::vector<MetricSeries> all_series = list_metric_series(result);
  for (const auto& [first, last] : group_metric_series(all_series)) {
    std::vector<Metric> member_metrics;
    for (std::size_t i = first; i < last; ++i) member_metrics.push_back(compute_metric(all_series[i], samples));
    if (!all_series[first].worst_group.empty())
      result.metrics.push_back(find_worst_metric(member_metrics, all_series[first].worst_group));
    result.metrics.insert(result.metrics.end(), member_metrics.begin(), member_metrics.end());
  }
  result.energy = integrate_power(result, samples);
}

namespace {

constexpr double move_time_tolerance =
    1e-9;  ///< of the run's duration: samples this near to the end of a move are there

/// @param position_round_off [m]
AdaptationMove record_move(const trajectory::CoordinateMove& move, Eigen::Index coordinate, Eigen::Index actuator,
                           double position_round_off, const std::vector<SampleReference>& samples) {
  AdaptationMove record;
  record.start = move.start, record.end = move.start + move.duration;
  const double tolerance = move_time_tolerance * (samples.back().time - samples.front().time);
  // of two sides of a jump, the ones within the move
  const auto first = std::find_if(samples.rbegin(), samples.rend(), [&](const SampleReference& sample) {
    return sample.time <= record.start + tolerance;
  });
  const auto last = std::find_if(samples.begin(), samples.end(),
                                 [&](const SampleReference& sample) { return sample.time >= record.end - tolerance; });
  const auto position = [&](const SampleReference& sample) {
    return suppress_round_off(position_round_off, sample.result->joint_position(sample.row, coordinate));
  };
  const auto power = [&](const SampleReference& sample) { return sample.result->power(sample.row, actuator); };
  record.from = position(*first), record.to = position(*last);
  record.peak_effort.setZero(samples.front().result->torque.cols());
  for (auto sample = first.base() - 1; sample <= last; ++sample) {
    record.peak_effort = record.peak_effort.cwiseMax(sample->result->torque.row(sample->row).transpose().cwiseAbs());
    if (sample == last) break;
    const auto next = sample + 1;
    const double half_step = (next->time - sample->time) / 2, before = power(*sample), after = power(*next);
    record.work += half_step * (before + after);
    record.energy += half_step * (std::abs(before) + std::abs(after));
  }
  return record;
}

}  // namespace

void add_adaptation_moves(const Mechanism& mechanism, const std::vector<trajectory::CoordinateCourse>& courses,
                          const IntermediateSamples& between, RunResult& result) {
  if (courses.empty() || result.time.size() < 2) return;
  const std::vector<SampleReference> samples = merge_in_time_order(result, between);
  const double duration = samples.back().time - samples.front().time,
               position_round_off = model::pose_round_off * characteristic_length(mechanism);
  for (const trajectory::CoordinateCourse& course : courses) {
    const auto entry = std::find(mechanism.actuators.begin(), mechanism.actuators.end(), course.coordinate);
    if (entry == mechanism.actuators.end()) continue;
    const Eigen::Index actuator = entry - mechanism.actuators.begin();
    for (const trajectory::CoordinateMove& move : course.moves) {
      if (move.start + move.duration > samples.back().time + move_time_tolerance * duration) break;
      AdaptationMove record = record_move(move, course.coordinate, actuator, position_round_off, samples);
      record.counterweight = result.actuator_names[static_cast<std::size_t>(actuator)];
      const double round_off = column_round_off(result, &RunResult::power, actuator) * duration;
      record.work = suppress_round_off(round_off, record.work);
      record.energy = suppress_round_off(round_off, record.energy);
      result.adaptation_moves.push_back(std::move(record));
    }
  }
}

Metric summarise_values(const std::vector<double>& values, const VectorX& times, double round_off) {
  Metric metric = summarise(values, [&](std::size_t i) { return times[static_cast<Eigen::Index>(i)]; });
  metric.round_off = round_off;
  zero_round_off(metric, times[0]);
  return metric;
}

double statistic_of(const Metric& metric, Statistic statistic) {
  switch (statistic) {
    case Statistic::peak: return metric.peak;
    case Statistic::rms: return metric.rms;
    case Statistic::mean: return metric.mean;
    case Statistic::range: return metric.range;
    case Statistic::minimum: return metric.minimum;
    case Statistic::maximum: return metric.maximum;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

namespace {

struct Overflow {
  double time = INFINITY;
  std::string what;
};

/// @param rows number of filled rows
void find_in_quantities(const RunResult& result, long rows, Overflow& first) {
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    const auto filled = quantity.samples->topRows(rows);
    if ((filled.array() - filled.array()).sum() == 0) continue;  // x − x is NaN if x is not finite
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
  for (const Metric& metric : result.metrics) {  // squares overflow long before the values
    const bool finite = std::isfinite(metric.peak) && std::isfinite(metric.rms) && std::isfinite(metric.mean) &&
                        std::isfinite(metric.range);
    if (!finite && metric.peak_time < first.time) first = {metric.peak_time, metric.quantity};
  }
  if (!std::isfinite(result.energy) && first.what.empty()) first = {result.time[0], "the energy moved"};
  if (first.what.empty()) return std::nullopt;
  return trajectory::make_overflow_outcome(first.time, first.what, mechanism);
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

/// @param tracked_names coordinates whose tracking is judged; empty: all
void add(const Quantity& quantity, Figures metric_scope, const RunResult& result, const Names& tracked_names,
         std::vector<MetricSeries>& all_series) {
  const int columns = static_cast<int>(quantity.samples->cols());
  if (metric_scope == Figures::whole) {
    all_series.push_back({quantity.name, quantity.units.front(), quantity.member, 0, columns, ""});
    return;
  }
  const std::vector<std::string>& names = column_owner_names(quantity.columns, result);
  const int width = columns / static_cast<int>(names.size());
  const auto first = static_cast<std::ptrdiff_t>(all_series.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (metric_scope == Figures::tracked && !tracked_names.empty() && !tracked_names.contains(names[i])) continue;
    const std::string& unit = quantity.unit_of(i, names.size());
    all_series.push_back({effort_display_name(quantity.name, unit) + "[" + names[i] + "]", unit, quantity.member,
                          static_cast<int>(i) * width, width});
  }
  // The worst of torques and forces together would have no unit.
  const auto begin = all_series.begin() + first;
  const bool has_uniform_unit =
      std::all_of(begin, all_series.end(), [&](const MetricSeries& series) { return series.unit == begin->unit; });
  if (metric_scope != Figures::per_member && has_uniform_unit)
    for (auto series = begin; series != all_series.end(); ++series) series->worst_group = quantity.name;
}

bool is_control_quantity(Availability availability) {
  constexpr std::array control_availabilities = {Availability::control, Availability::tracking,
                                                 Availability::tool_tracking};
  return std::find(control_availabilities.begin(), control_availabilities.end(), availability) !=
         control_availabilities.end();
}

}  // namespace

std::vector<MetricSeries> list_metric_series(const RunResult& result) {
  const std::vector<Quantity> quantities = list_all_quantities(result);
  const Names tracked_names(result.actuator_names.begin(), result.actuator_names.end());
  std::vector<MetricSeries> all_series;
  for (const bool control : {true, false})
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      const QuantityDefinition& kind = quantity_table()[q];
      if (is_control_quantity(kind.occasion) == control && kind.figures != Figures::none &&
          quantities[q].samples->cols() > 0)
        add(quantities[q], kind.figures, result, tracked_names, all_series);
    }
  return all_series;
}

std::vector<std::pair<std::size_t, std::size_t>> group_metric_series(const std::vector<MetricSeries>& all_series) {
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  for (std::size_t i = 0; i < all_series.size(); ++i) {
    const bool continues_range =
        i > 0 && !all_series[i].worst_group.empty() && all_series[i].worst_group == all_series[i - 1].worst_group;
    if (continues_range)
      ranges.back().second = i + 1;
    else
      ranges.emplace_back(i, i + 1);
  }
  return ranges;
}

namespace {

std::vector<MetricSeries> list_mechanism_series(const Mechanism& mechanism) {
  RunResult shape;
  name_columns(mechanism, shape);
  resize_arrays(mechanism, 1, {}, shape);
  return list_metric_series(shape);
}

}  // namespace

std::vector<std::string> list_metric_names(const Mechanism& mechanism) {
  const std::vector<MetricSeries> all_series = list_mechanism_series(mechanism);
  std::vector<std::string> names;
  for (const auto& [first, last] : group_metric_series(all_series)) {
    if (!all_series[first].worst_group.empty()) names.push_back(all_series[first].worst_group);
    for (std::size_t i = first; i < last; ++i) names.push_back(all_series[i].quantity);
  }
  return names;
}

std::string find_metric_unit(const Mechanism& mechanism, const std::string& name) {
  for (const MetricSeries& series : list_mechanism_series(mechanism))
    if (is_quantity_name(name, series.quantity) || (!series.worst_group.empty() && series.worst_group == name))
      return series.unit;
  return "";
}

}  // namespace balance::results
