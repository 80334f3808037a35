#include "balance/synthesis/design/start_agreement.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

StartAgreement compare_starts(const std::vector<double>& ends, double best) {
  StartAgreement agreement;
  agreement.starts = static_cast<int>(ends.size());
  bool has_other = false;
  double largest = std::abs(best);
  for (const double end : ends)
    if (std::isfinite(end)) largest = std::max(largest, std::abs(end));
  // next to zero, 1e-12 of the largest end is round-off (relative_figure_round_off)
  const double size = std::max({std::abs(best), 1e-6 * largest, 1e-300});
  for (const double end : ends) {
    if (!std::isfinite(end)) {
      ++agreement.failed;
      continue;
    }
    const double distance = (end - best) / size;
    if (distance <= start_agreement_tolerance) {
      ++agreement.agreeing;
      continue;
    }
    agreement.nearest_other = has_other ? std::min(agreement.nearest_other, distance) : distance;
    agreement.farthest_other = std::max(agreement.farthest_other, distance);
    has_other = true;
  }
  return agreement;
}

}  // namespace balance::design
