#include "balance/timing/steady_momentum.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace balance {
namespace {

constexpr int nodes_per_panel = 64;             // of a panel: between nodes the law is a quintic
constexpr double min_momentum_fraction = 1e-6;  // of the largest momentum per rate: nearer to zero the law has no bound

/// @param speed of what is driven, at the start, per rate of the path's parameter
std::string explain_sign_change(double place, const ConstantMomentumLaw& law, double speed) {
  const double unit = speed > 0 ? speed : 1;
  char text[320];
  std::snprintf(text, sizeof text,
                "at %.6g %% of the path the angular momentum cannot be kept: per unit of the drive's rate it goes "
                "through zero (it is "
                "from %.8g to %.8g in SI units)",
                100 * place, law.min_momentum_per_rate / unit, law.max_momentum_per_rate / unit);
  return text;
}

/// @return where the function is nearest to zero or beyond it, as seen from its mean
double find_momentum_range(const PiecewiseChebyshevSeries& g, ConstantMomentumLaw& law) {
  std::vector<double> places = find_roots(g.derivative(), 0);
  for (const Panel& panel : g.panels()) places.insert(places.end(), {panel.begin, panel.end});
  law.min_momentum_per_rate = INFINITY, law.max_momentum_per_rate = -INFINITY;
  double least_at = 0, most_at = 0, value = 0;
  for (const double place : places) {
    g.evaluate(g.find_panel(place, 0, g.panels().size()), place, &value);
    if (value < law.min_momentum_per_rate) law.min_momentum_per_rate = value, least_at = place;
    if (value > law.max_momentum_per_rate) law.max_momentum_per_rate = value, most_at = place;
  }
  return law.max_momentum_per_rate > -law.min_momentum_per_rate ? least_at : most_at;
}

}  // namespace

ConstantMomentumLaw find_constant_momentum_law(const PathModel& model, double duration) {
  ConstantMomentumLaw found;
  found.law.kind = MotionLawKind::constant_momentum;
  const PathConstraintRow& row = model.rows.front();
  const int column = row.a;
  if (column < 0) {
    found.refusal = "the mechanism has no angular momentum on this path that could be kept";
    return found;
  }
  std::vector<Panel> panels = model.value.panels();
  for (Panel& panel : panels) panel.coefficients = Samples(panel.coefficients.col(column));
  const PiecewiseChebyshevSeries g(std::move(panels)), sum = g.integral();
  VectorX all(model.value.function_count());
  const double narrow = find_momentum_range(g, found);
  if (!(found.min_momentum_per_rate * found.max_momentum_per_rate > 0) ||
      std::min(std::abs(found.min_momentum_per_rate), std::abs(found.max_momentum_per_rate)) <
          min_momentum_fraction * std::max(-found.min_momentum_per_rate, found.max_momentum_per_rate)) {
    found.refusal = explain_sign_change(narrow, found, model.start_speed);
    return found;
  }
  double whole = 0;
  sum.evaluate(sum.panels().size() - 1, 1, &whole);
  found.momentum = whole / duration;
  for (std::size_t p = 0; p < g.panels().size(); ++p)
    for (int k = p == 0 ? 0 : 1; k <= nodes_per_panel; ++k) {
      const Panel& panel = g.panels()[p];
      const double s = k == nodes_per_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / nodes_per_panel;
      double passed = 0;
      model.value.evaluate(p, s, all.data());
      sum.evaluate(p, s, &passed);
      const double here = all[column], rising = row.b < 0 ? 0 : all[row.b];  // g' is what s'² leaves of the moment
      const double rate = whole / here, second = -rate * rate * rising / here;
      found.law.nodes.push_back({passed / whole, s, rate, second, second});
    }
  found.law.nodes.back().tau = 1;
  return found;
}

}  // namespace balance
