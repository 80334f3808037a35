#include "balance/present/design_view.hpp"

#include "balance/analysis/objective.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/round_off.hpp"
#include "balance/result/tracks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace balance {
namespace {

std::string term_text(const ObjectiveTerm& term) {
  if (term.size != ObjectiveTerm::Size::none || term.run == ObjectiveTerm::RunMeasure::duration)
    return objective_term_name(term);
  const std::string figure =
      fmt::format("{} of {} along {}", objective_term_name(term.figure), term.quantity, term.trajectory);
  return term.deviation_multiple ? fmt::format("mean plus {:g} deviation{} of the {}", *term.deviation_multiple,
                                               *term.deviation_multiple == 1 ? "" : "s", figure)
                                 : figure;
}

bool is_shown(const std::string& quantity) {
  return effort_array_name(quantity).starts_with("torque") || quantity.starts_with("shaking_");
}

const Metric* find(const RunResult& result, const std::string& quantity) {
  for (const Metric& metric : result.metrics)
    if (metric.quantity == quantity) return &metric;
  return nullptr;
}

}  // namespace

std::string objective_text(const std::vector<ObjectiveTerm>& terms) {
  std::string text;
  for (const ObjectiveTerm& term : terms) {
    if (!text.empty()) text += " + ";
    if (term.weight != 1) text += fmt::format("{:g} ", term.weight);
    text += term_text(term);
  }
  return text;
}

std::string objective_unit(const std::vector<ObjectiveTerm>& terms, const Mechanism& mechanism) {
  if (terms.size() != 1 || terms.front().weight != 1) return "";
  const ObjectiveTerm& term = terms.front();
  if (term.size == ObjectiveTerm::Size::added_inertia) return "kg m^2";
  if (term.size != ObjectiveTerm::Size::none) return "kg";
  if (term.run == ObjectiveTerm::RunMeasure::duration) return "s";
  return find_metric_unit(mechanism, term.quantity);
}

int active_bound(const FreeNumber& number, double value) {
  const double near = 1e-9 * (number.upper - number.lower);
  return value <= number.lower + near ? -1 : value >= number.upper - near ? 1 : 0;
}

std::vector<MetricChange> list_metric_changes(const TrajectoryComparison& comparison) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const RunResult &before = comparison.before, &after = comparison.after;
  std::vector<MetricChange> changes;
  for (const Metric& metric : (before.metrics.empty() ? after : before).metrics) {
    if (!is_shown(metric.quantity)) continue;
    const Metric *old = find(before, metric.quantity), *fresh = find(after, metric.quantity);
    // what the terms of either mechanism leave of zero
    const double round_off = std::max(old != nullptr ? old->round_off : 0, fresh != nullptr ? fresh->round_off : 0);
    const auto add = [&](const char* figure, double Metric::*value) {
      const double was = old != nullptr ? old->*value : unknown, is = fresh != nullptr ? fresh->*value : unknown;
      changes.push_back({metric.quantity, metric.unit, figure, suppress_round_off(round_off, was),
                         suppress_round_off(round_off, is)});
    };
    add("peak", &Metric::peak);
    add("rms", &Metric::rms);
  }
  return changes;
}

}  // namespace balance
