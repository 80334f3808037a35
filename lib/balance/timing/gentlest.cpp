#include "balance/timing/gentlest.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace balance {
namespace {

constexpr double met_duration = 1e-10;  // of the duration
constexpr double no_gain = 1e-4;        // of the duration, by four times the excess: the other limits rule
constexpr double most_excess = 1e12;    // over what the motion is worth at its mean rate
constexpr double no_weight = 1e-9;      // parts of a quantity that do not depend on the motion, of those that do

class GentlestSearch {
 public:
  GentlestSearch(const PathModel& model, const std::vector<double>& limits, const EndRates& rates, double duration)
      : model_(model), limits_(limits), rates_(rates), duration_(duration) {
    for (std::size_t r = limits.size(); r < model.rows.size(); ++r) {
      const LimitRow& row = model.rows[r];
      at_rest_ = std::max(at_rest_, largest(row.c, row));
      moving_ = std::max({moving_, largest(row.a, row), largest(row.b, row)});
      friction_ = std::max(friction_, largest(row.d, row));
    }
  }

  GentlestLaw run() {
    if (!(std::max(moving_, friction_) > 0)) return refusal("it is zero along this path by whatever law");
    // a s'' + b s'² alone: by a change of time scale every peak goes with 1/T²
    const double rate = 1 / duration_;
    const double size = moving_ * rate * rate;
    const bool homogeneous = limits_.empty() && at_rest_ <= no_weight * size && friction_ * rate <= no_weight * size &&
                             rates_.start == 0 && rates_.end == 0;
    return homogeneous ? by_scaling(size) : by_bisection(size + friction_ * rate);
  }

 private:
  double largest(int column, const LimitRow& row) const {
    return column < 0 ? 0 : max_abs(model_.largest.segment(column, row.count));
  }

  static GentlestLaw refusal(std::string text) {
    GentlestLaw none;
    none.law.refusal = std::move(text);
    return none;
  }

  GentlestLaw at(double peak) const {
    GentlestLaw result;
    result.peak = peak;
    result.bounds = limits_;
    result.bounds.resize(model_.rows.size(), peak);
    result.law = find_fastest(model_, result.bounds, rates_);
    return result;
  }

  GentlestLaw by_scaling(double peak) const {
    GentlestLaw result = at(peak);
    if (!result.law.refusal.empty()) return result;
    const double ratio = result.law.duration() / duration_;
    result.peak = peak * ratio * ratio;
    return result;
  }

  /// The least duration falls as the peak rises: bracket, then halve, by the peak's excess over what rest needs.
  GentlestLaw by_bisection(double scale) const {
    double low = 1e-6 * std::max(scale, at_rest_), high = scale;
    GentlestLaw slow = at(at_rest_ + low);
    if (slow.law.refusal.empty() && slow.law.duration() <= duration_) {
      if (rates_.start != 0 || rates_.end != 0)
        return refusal("any law that is slow enough has the peak of rest: a longer way at rest is not sought");
      return slow;  // its pace may be slackened: nothing grows beyond what rest needs
    }
    GentlestLaw fast = at(at_rest_ + high);
    while (!(fast.law.refusal.empty() && fast.law.duration() <= duration_)) {
      low = high;
      high *= 4;
      GentlestLaw faster = at(at_rest_ + high);
      const bool gains = faster.law.refusal.empty() &&
                         (!fast.law.refusal.empty() || faster.law.duration() < (1 - no_gain) * fast.law.duration());
      if (!gains && (fast.law.refusal.empty() || high > most_excess * scale)) return too_short(fast);
      fast = std::move(faster);
    }
    for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
      const double middle = std::sqrt(low * high);
      GentlestLaw tried = at(at_rest_ + middle);
      if (tried.law.refusal.empty() && tried.law.duration() <= duration_) {
        fast = std::move(tried);
        high = middle;
        if (duration_ - fast.law.duration() < met_duration * duration_) break;
      } else {
        low = middle;
      }
    }
    return fast;
  }

  GentlestLaw too_short(const GentlestLaw& fast) const {
    if (!fast.law.refusal.empty()) return refusal(fast.law.refusal);
    char text[160];
    std::snprintf(text, sizeof text, "the duration is too short: the other limits alone need %.6g s",
                  fast.law.duration());
    return refusal(text);
  }

  const PathModel& model_;
  const std::vector<double>& limits_;
  EndRates rates_;
  double duration_;
  double at_rest_ = 0, moving_ = 0, friction_ = 0;
};

}  // namespace

GentlestLaw find_gentlest(const PathModel& model, const std::vector<double>& limits, const EndRates& rates,
                          double duration) {
  return GentlestSearch(model, limits, rates, duration).run();
}

}  // namespace balance
