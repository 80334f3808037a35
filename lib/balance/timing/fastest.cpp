#include "balance/timing/fastest.hpp"

#include "balance/timing/kept_limits.hpp"
#include "balance/timing/leg_by_arcs.hpp"
#include "balance/timing/swept.hpp"

#include <cstdio>

namespace balance {
namespace {

constexpr double a_little = 1e-5;  // of a limit

/// Appends a leg.
void add_leg(const FastestLaw& part, FastestLaw& law) {
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
FastestLaw by_arcs(const PathModel& model, std::vector<double> bounds, const LegOfPath& leg, const EndRates& rates) {
  const FastestLaw law = find_leg_by_arcs(model, bounds, leg, rates);
  if (!law.refusal.empty()) return law;
  const double load = worst_load(model, bounds, law);
  if (load < 1 + kept || load > 1 + a_little) return law;
  for (double& bound : bounds) bound /= load;
  return find_leg_by_arcs(model, bounds, leg, rates);
}

}  // namespace

FastestLaw find_fastest(const PathModel& model, const std::vector<double>& bounds, const EndRates& rates) {
  FastestLaw law;
  law.refusal = find_unholdable(model, bounds);
  if (!law.refusal.empty()) return law;
  const std::vector<LegOfPath> legs = cut_legs(model);
  for (const LegOfPath& leg : legs) {
    const EndRates own{&leg == &legs.front() ? rates.start : 0, &leg == &legs.back() ? rates.end : 0};
    FastestLaw part = by_arcs(model, bounds, leg, own);
    if (!part.refusal.empty() || !(worst_load(model, bounds, part) < 1 + kept)) {
      FastestLaw swept = sweep_leg(model, bounds, leg, own);
      if (swept.refusal.empty()) part = std::move(swept);
    }
    law.refusal = part.refusal;
    if (!law.refusal.empty()) return law;
    add_leg(part, law);
  }
  return law;
}

std::string find_unholdable(const PathModel& model, const std::vector<double>& bounds) {
  Allowed allowed(model, bounds);
  double worst = 1 + 1e-9, place = 0;
  int row = -1;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 32; ++k) {
      const double s = panel.begin + (panel.end - panel.begin) * k / 32;
      allowed.go(s, p, p + 1);
      for (std::size_t r = 0; r < bounds.size(); ++r) {
        const double load = allowed.magnitude(static_cast<int>(r), 0, 0) / bounds[r];
        if (load > worst) worst = load, place = s, row = static_cast<int>(r);
      }
    }
  }
  if (row < 0) return "";
  const LimitRow& unheld = model.rows[static_cast<std::size_t>(row)];
  const double bound = bounds[static_cast<std::size_t>(row)];
  const char* unit = unheld.unit.c_str();
  char text[200];
  if (unheld.middle == 0) {
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s more than its limit", worst * bound, unit,
                  (worst - 1) * bound, unit);
  } else {
    allowed.go(place, 0, model.value.panels().size());
    const double value = allowed.at_rest(row);
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s %s than its limit", value, unit,
                  (worst - 1) * bound, unit, value > unheld.middle ? "more" : "less");
  }
  return place_text(place) + " " + unheld.name + text;
}

}  // namespace balance
