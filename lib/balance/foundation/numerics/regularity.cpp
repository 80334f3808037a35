#include "balance/foundation/numerics/regularity.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

double PivotExtrapolation::extrapolate_zero(double found) const {
  const auto& [first, second, third] = samples_;
  if (!(first.pivot > second.pivot && second.pivot > third.pivot && third.pivot > 0)) return found;
  double best = found, least = 0.02 * (third.time - first.time);
  for (const double power : {0.5, 1.0, 2.0}) {
    const auto extrapolated = [power](const PivotSample& a,
                                      const PivotSample& b) {  // pivot^(1/power) is linear in the time
      return b.time + (b.time - a.time) / (elementary::pow(a.pivot / b.pivot, 1 / power) - 1);
    };
    const double time = extrapolated(second, third);
    const double doubt = std::abs(time - extrapolated(first, second));
    if (!(doubt < least)) continue;
    // The trail may be that of another part, which comes to its own singularity a little later.
    const double left =
        third.pivot * elementary::pow(std::max(0.0, (time - min_pivot_time_) / (time - third.time)), power);
    if (!(left <= min_pivot_ + 0.02 * third.pivot)) continue;
    least = doubt;
    best = time;
  }
  // what was found lies between there and the last of the trail
  return best > third.time && best >= found - 0.1 * (best - third.time) ? best : found;
}

}  // namespace balance
