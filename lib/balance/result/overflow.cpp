#include "balance/result/overflow.hpp"

#include "balance/motion/wording.hpp"
#include "balance/result/quantities.hpp"

#include <cmath>

namespace balance {

namespace {

struct Overflow {
  double time = INFINITY;
  std::string what;
};

/// @param rows that are filled
void find_in_quantities(const RunResult& result, long rows, Overflow& first) {
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    const auto filled = quantity.samples->topRows(rows);
    if ((filled.array() - filled.array()).sum() == 0)
      continue;  // a number minus itself is not a number where it is none
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
  for (const Metric& metric : result.metrics) {  // squares overflow long before what they are squares of
    const bool finite = std::isfinite(metric.peak) && std::isfinite(metric.rms) && std::isfinite(metric.mean) &&
                        std::isfinite(metric.range);
    if (!finite && metric.peak_time < first.time) first = {metric.peak_time, metric.quantity};
  }
  if (!std::isfinite(result.energy) && first.what.empty()) first = {result.time[0], "the energy moved"};
  if (first.what.empty()) return std::nullopt;
  return make_overflow_outcome(first.time, first.what, mechanism);
}

}  // namespace balance
