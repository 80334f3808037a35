#include "balance/timing/steady_momentum.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace balance {
namespace {

constexpr int parts_of_panel = 64;   // of a panel: between nodes the law is a quintic
constexpr double least_part = 1e-6;  // of the largest momentum per rate: nearer to zero the law has no bound

/// @param speed of what is driven, at the start, per rate of the path's parameter
std::string refusal_at(double place, const SteadyLaw& law, double speed) {
  const double unit = speed > 0 ? speed : 1;
  char text[320];
  std::snprintf(text, sizeof text,
                "at %.6g %% of the path the angular momentum cannot be kept: per unit of the drive's rate it goes "
                "through zero (it is "
                "from %.8g to %.8g in SI units)",
                100 * place, law.least / unit, law.most / unit);
  return text;
}

/// @return where the function is nearest to zero or beyond it, as seen from its mean
double range(const PiecewiseSeries& g, SteadyLaw& law) {
  std::vector<double> places = zeros(g.derivative(), 0);
  for (const Panel& panel : g.panels()) places.insert(places.end(), {panel.begin, panel.end});
  law.least = INFINITY, law.most = -INFINITY;
  double least_at = 0, most_at = 0, value = 0;
  for (const double place : places) {
    g.at(g.panel_at(place, 0, g.panels().size()), place, &value);
    if (value < law.least) law.least = value, least_at = place;
    if (value > law.most) law.most = value, most_at = place;
  }
  return law.most > -law.least ? least_at : most_at;
}

}  // namespace

SteadyLaw find_steady_momentum(const PathModel& model, double duration) {
  SteadyLaw found;
  found.law.kind = LawKind::steady_momentum;
  const LimitRow& row = model.rows.front();
  const int column = row.a;
  if (column < 0) {
    found.refusal = "the mechanism has no angular momentum on this path that could be kept";
    return found;
  }
  std::vector<Panel> panels = model.value.panels();
  for (Panel& panel : panels) panel.terms = Samples(panel.terms.col(column));
  const PiecewiseSeries g(std::move(panels)), sum = g.integral();
  VectorX all(model.value.functions());
  const double narrow = range(g, found);
  if (!(found.least * found.most > 0) ||
      std::min(std::abs(found.least), std::abs(found.most)) < least_part * std::max(-found.least, found.most)) {
    found.refusal = refusal_at(narrow, found, model.start_speed);
    return found;
  }
  double whole = 0;
  sum.at(sum.panels().size() - 1, 1, &whole);
  found.momentum = whole / duration;
  for (std::size_t p = 0; p < g.panels().size(); ++p)
    for (int k = p == 0 ? 0 : 1; k <= parts_of_panel; ++k) {
      const Panel& panel = g.panels()[p];
      const double s = k == parts_of_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / parts_of_panel;
      double passed = 0;
      model.value.at(p, s, all.data());
      sum.at(p, s, &passed);
      const double here = all[column], rising = row.b < 0 ? 0 : all[row.b];  // g' is what s'² leaves of the moment
      const double rate = whole / here, second = -rate * rate * rising / here;
      found.law.nodes.push_back({passed / whole, s, rate, second, second});
    }
  found.law.nodes.back().tau = 1;
  return found;
}

}  // namespace balance
