#include "balance/timing/gentlest.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace balance {
namespace {

constexpr double duration_tolerance = 1e-10;  // of the duration
constexpr double min_duration_gain = 1e-4;    // of the duration, by four times the excess: the other limits rule
constexpr double max_relative_peak = 1e12;    // over what the motion is worth at its mean rate
constexpr double constant_part_epsilon =
    1e-9;  // parts of a quantity that do not depend on the motion, of those that do

class MinPeakSearch {
 public:
  MinPeakSearch(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates, double duration)
      : model_(model), limits_(limits), rates_(rates), duration_(duration) {
    for (std::size_t r = limits.size(); r < model.rows.size(); ++r) {
      const PathConstraintRow& row = model.rows[r];
      at_rest_ = std::max(at_rest_, largest(row.c, row));
      moving_ = std::max({moving_, largest(row.a, row), largest(row.b, row)});
      friction_ = std::max(friction_, largest(row.d, row));
    }
  }

  MinPeakLaw run() {
    if (!(std::max(moving_, friction_) > 0)) return refusal("it is zero along this path by whatever law");
    // a s'' + b s'² alone: by a change of time scale every peak goes with 1/T²
    const double rate = 1 / duration_;
    const double size = moving_ * rate * rate;
    const bool homogeneous = limits_.empty() && at_rest_ <= constant_part_epsilon * size &&
                             friction_ * rate <= constant_part_epsilon * size && rates_.start == 0 && rates_.end == 0;
    return homogeneous ? by_scaling(size) : by_bisection(size + friction_ * rate);
  }

 private:
  double largest(int column, const PathConstraintRow& row) const {
    return column < 0 ? 0 : max_abs(model_.max_magnitude.segment(column, row.count));
  }

  static MinPeakLaw refusal(std::string text) {
    MinPeakLaw none;
    none.law.infeasibility_reason = std::move(text);
    return none;
  }

  MinPeakLaw at(double peak) const {
    MinPeakLaw result;
    result.peak = peak;
    result.bounds = limits_;
    result.bounds.resize(model_.rows.size(), peak);
    result.law = find_time_optimal_law(model_, result.bounds, rates_);
    return result;
  }

  MinPeakLaw by_scaling(double peak) const {
    MinPeakLaw result = at(peak);
    if (!result.law.infeasibility_reason.empty()) return result;
    const double ratio = result.law.duration() / duration_;
    result.peak = peak * ratio * ratio;
    return result;
  }

  /// The least duration falls as the peak rises: bracket, then halve, by the peak's excess over what rest needs.
  MinPeakLaw by_bisection(double scale) const {
    double low = 1e-6 * std::max(scale, at_rest_), high = scale;
    MinPeakLaw slow = at(at_rest_ + low);
    if (slow.law.infeasibility_reason.empty() && slow.law.duration() <= duration_) {
      if (rates_.start != 0 || rates_.end != 0)
        return refusal("any law that is slow enough has the peak of rest: a longer way at rest is not sought");
      return slow;  // its pace may be slackened: nothing grows beyond what rest needs
    }
    MinPeakLaw fast = at(at_rest_ + high);
    while (!(fast.law.infeasibility_reason.empty() && fast.law.duration() <= duration_)) {
      low = high;
      high *= 4;
      MinPeakLaw faster = at(at_rest_ + high);
      const bool gains = faster.law.infeasibility_reason.empty() &&
                         (!fast.law.infeasibility_reason.empty() ||
                          faster.law.duration() < (1 - min_duration_gain) * fast.law.duration());
      if (!gains && (fast.law.infeasibility_reason.empty() || high > max_relative_peak * scale))
        return report_short_duration(fast);
      fast = std::move(faster);
    }
    for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
      const double middle = std::sqrt(low * high);
      MinPeakLaw tried = at(at_rest_ + middle);
      if (tried.law.infeasibility_reason.empty() && tried.law.duration() <= duration_) {
        fast = std::move(tried);
        high = middle;
        if (duration_ - fast.law.duration() < duration_tolerance * duration_) break;
      } else {
        low = middle;
      }
    }
    return fast;
  }

  MinPeakLaw report_short_duration(const MinPeakLaw& fast) const {
    if (!fast.law.infeasibility_reason.empty()) return refusal(fast.law.infeasibility_reason);
    char text[160];
    std::snprintf(text, sizeof text, "the duration is too short: the other limits alone need %.6g s",
                  fast.law.duration());
    return refusal(text);
  }

  const PathModel& model_;
  const std::vector<double>& limits_;
  EndpointRates rates_;
  double duration_;
  double at_rest_ = 0, moving_ = 0, friction_ = 0;
};

}  // namespace

MinPeakLaw find_min_peak_law(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates,
                             double duration) {
  return MinPeakSearch(model, limits, rates, duration).run();
}

}  // namespace balance
