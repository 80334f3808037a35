#include "balance/timing/fastest.hpp"

#include "balance/timing/kept_limits.hpp"
#include "balance/timing/leg_by_arcs.hpp"
#include "balance/timing/swept.hpp"

#include <cstdio>

namespace balance {
namespace {

constexpr double max_relative_violation = 1e-5;  // of a limit

/// Appends a leg.
void append_segment(const TimeOptimalLaw& part, TimeOptimalLaw& law) {
  const double start = law.nodes.empty() ? 0 : law.duration();
  auto first = part.nodes.begin();
  if (!law.nodes.empty()) {
    law.nodes.back().u_after = first->u_after;
    law.nodes.back().row_after = first->row_after;
    ++first;
  }
  for (; first != part.nodes.end(); ++first) {
    law.nodes.push_back(*first);
    law.nodes.back().t += start;
  }
}

/// By arcs, whose quintics may go a little beyond a limit between their nodes: then within limits that are smaller by that.
TimeOptimalLaw solve_by_integration(const PathModel& model, std::vector<double> bounds, const SegmentRange& leg,
                                    const EndpointRates& rates) {
  const TimeOptimalLaw law = integrate_phase_plane(model, bounds, leg, rates);
  if (!law.infeasibility_reason.empty()) return law;
  const double load = find_max_limit_ratio(model, bounds, law);
  if (load < 1 + limit_violation_tolerance || load > 1 + max_relative_violation) return law;
  for (double& bound : bounds) bound /= load;
  return integrate_phase_plane(model, bounds, leg, rates);
}

}  // namespace

TimeOptimalLaw find_time_optimal_law(const PathModel& model, const std::vector<double>& bounds,
                                     const EndpointRates& rates) {
  TimeOptimalLaw law;
  law.infeasibility_reason = check_static_feasibility(model, bounds);
  if (!law.infeasibility_reason.empty()) return law;
  const std::vector<SegmentRange> legs = split_into_segments(model);
  for (const SegmentRange& leg : legs) {
    const EndpointRates own{&leg == &legs.front() ? rates.start : 0, &leg == &legs.back() ? rates.end : 0};
    TimeOptimalLaw part = solve_by_integration(model, bounds, leg, own);
    if (!part.infeasibility_reason.empty() ||
        !(find_max_limit_ratio(model, bounds, part) < 1 + limit_violation_tolerance)) {
      TimeOptimalLaw swept = solve_by_reachability(model, bounds, leg, own);
      if (swept.infeasibility_reason.empty()) part = std::move(swept);
    }
    law.infeasibility_reason = part.infeasibility_reason;
    if (!law.infeasibility_reason.empty()) return law;
    append_segment(part, law);
  }
  return law;
}

std::string check_static_feasibility(const PathModel& model, const std::vector<double>& bounds) {
  AccelerationLimits allowed(model, bounds);
  double worst = 1 + 1e-9, place = 0;
  int row = -1;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 32; ++k) {
      const double s = panel.begin + (panel.end - panel.begin) * k / 32;
      allowed.move_to(s, p, p + 1);
      for (std::size_t r = 0; r < bounds.size(); ++r) {
        const double load = allowed.magnitude(static_cast<int>(r), 0, 0) / bounds[r];
        if (load > worst) worst = load, place = s, row = static_cast<int>(r);
      }
    }
  }
  if (row < 0) return "";
  const PathConstraintRow& unheld = model.rows[static_cast<std::size_t>(row)];
  const double bound = bounds[static_cast<std::size_t>(row)];
  const char* unit = unheld.unit.c_str();
  char text[200];
  if (unheld.centre == 0) {
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s more than its limit", worst * bound, unit,
                  (worst - 1) * bound, unit);
  } else {
    allowed.move_to(place, 0, model.value.panels().size());
    const double value = allowed.static_value(row);
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s %s than its limit", value, unit,
                  (worst - 1) * bound, unit, value > unheld.centre ? "more" : "less");
  }
  return format_path_parameter(place) + " " + unheld.name + text;
}

}  // namespace balance
