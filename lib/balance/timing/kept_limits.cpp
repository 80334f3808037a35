#include "balance/timing/kept_limits.hpp"

#include <algorithm>

namespace balance {

double find_max_limit_ratio_between(const PathModel& model, const std::vector<double>& bounds,
                                    AccelerationLimits& allowed, const TimeLawNode& a, const TimeLawNode& b) {
  const ProfilePoint first{a.t, a.s, a.v, a.u_after, -1}, second{b.t, b.s, b.v, b.u_before, -1};
  double worst = 0;
  for (const double part : {0.25, 0.5, 0.75}) {
    const ProfilePoint here = interpolate(first, second, a.t + part * (b.t - a.t));
    allowed.move_to(here.s, 0, model.value.panels().size());
    for (std::size_t r = 0; r < bounds.size(); ++r) {
      const double load = allowed.magnitude(static_cast<int>(r), here.v * here.v, here.u) / bounds[r];
      worst = std::max(worst, load);
    }
  }
  return worst;
}

double find_max_limit_ratio(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law) {
  AccelerationLimits allowed(model, bounds);
  double worst = 0;
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
    worst = std::max(worst, find_max_limit_ratio_between(model, bounds, allowed, law.nodes[k], law.nodes[k + 1]));
  return worst;
}

}  // namespace balance
