#include "balance/foundation/numerics/regularity.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace balance::numerics {

double PivotExtrapolation::extrapolate_zero(double detected_time) const {
  const auto& [first, second, third] = samples_;
  if (!(first.pivot > second.pivot && second.pivot > third.pivot && third.pivot > 0)) return detected_time;
  double best_time = detected_time, min_uncertainty = 0.02 * (third.time - first.time);
  for (const double power : {0.5, 1.0, 2.0}) {
    const auto extrapolated = [power](const PivotSample& a,
                                      const PivotSample& b) {  // pivot^(1/power) is linear in the time
      return b.time + (b.time - a.time) / (elementary::pow(a.pivot / b.pivot, 1 / power) - 1);
    };
    const double time = extrapolated(second, third);
    const double uncertainty = std::abs(time - extrapolated(first, second));
    if (!(uncertainty < min_uncertainty)) continue;
    // The samples may belong to another part, which reaches its own singularity a little later.
    const double extrapolated_pivot =
        third.pivot * elementary::pow(std::max(0.0, (time - min_pivot_time_) / (time - third.time)), power);
    if (!(extrapolated_pivot <= min_pivot_ + 0.02 * third.pivot)) continue;
    min_uncertainty = uncertainty;
    best_time = time;
  }
  // `detected_time` lies between the last sample and the zero
  return best_time > third.time && best_time >= detected_time - 0.1 * (best_time - third.time) ? best_time
                                                                                               : detected_time;
}

}  // namespace balance::numerics
