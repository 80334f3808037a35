#include "balance/motion/vibration/speed_sweep.hpp"

#include "balance/foundation/numerics/bracketed_root.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance::vibration {

namespace {

constexpr double growth_tolerance = 1e-9;  // of the largest |λ|: real parts up to this are round-off
constexpr double zero_tolerance = 1e-10;  // of the largest |λ|: rigid motions, whose eigenvalues are zero at all values
constexpr double root_tolerance = 1e-13;      // of a value at which something changes
constexpr double interpolation_step = 1e-3;   // of the distance of neighbouring values, for the last digits of a root
constexpr double bisection_tolerance = 1e-9;  // likewise, where a real part does not pass through zero

double find_size(const std::vector<std::complex<double>>& eigenvalues) {
  double size = 0;
  for (const std::complex<double> value : eigenvalues) size = std::max(size, std::abs(value));
  return size;
}

class SpeedSweeper {
 public:
  SpeedSweeper(const std::function<SweptCase(double)>& case_at, const SweepOptions& options)
      : case_at_(case_at), options_(options) {}

  SpeedSweep run(const simulation::Progress& progress) {
    const std::size_t count = options_.values.size();
    for (std::size_t k = 0; k < count; ++k) {
      sweep_.points.push_back(find_point(k));
      if (progress) progress(static_cast<double>(k + 1) / static_cast<double>(count));
    }
    for (std::size_t k = 0; k + 1 < count; ++k) {
      find_stability_changes(sweep_.points[k], sweep_.points[k + 1]);
      find_critical_speeds(sweep_.points[k], sweep_.points[k + 1]);
    }
    std::sort(sweep_.critical_speeds.begin(), sweep_.critical_speeds.end(),
              [](const CriticalSpeed& a, const CriticalSpeed& b) { return a.value < b.value; });
    return std::move(sweep_);
  }

 private:
  using Eigenvalues = std::vector<std::complex<double>>;

  bool is_exact(std::size_t k) const {
    const std::size_t last = options_.values.size() - 1;
    const auto exact = static_cast<std::size_t>(options_.exact_count);
    if (exact == 0) return false;
    if (exact == 1) return k == last / 2;
    for (std::size_t e = 0; e < exact; ++e)
      if (k == (2 * e * last + exact - 1) / (2 * (exact - 1))) return true;
    return false;
  }

  SweepPoint find_point(std::size_t k) {
    SweepPoint point;
    point.value = options_.values[k];
    const SweptCase swept = case_at_(point.value);
    const Trajectory* trajectory = swept.trajectory ? &*swept.trajectory : nullptr;
    point.modes = find_vibration_modes(swept.mechanism, trajectory);
    point.response =
        find_forced_response(swept.mechanism, trajectory, point.modes.motion, {options_.highest_order, is_exact(k)});
    return point;
  }

  Eigenvalues eigenvalues_at(double value) const {
    const SweptCase swept = case_at_(value);
    return find_vibration_modes(swept.mechanism, swept.trajectory ? &*swept.trajectory : nullptr).eigenvalues;
  }

  static std::ptrdiff_t count_zeros(const Eigenvalues& eigenvalues) {
    const double threshold = zero_tolerance * find_size(eigenvalues);
    return std::count_if(eigenvalues.begin(), eigenvalues.end(),
                         [&](const auto& value) { return std::abs(value) <= threshold; });
  }

  static Eigenvalues without_smallest(Eigenvalues eigenvalues, std::ptrdiff_t count) {
    for (; count > 0 && !eigenvalues.empty(); --count)
      eigenvalues.erase(std::min_element(eigenvalues.begin(), eigenvalues.end(),
                                         [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); }));
    return eigenvalues;
  }

  static std::size_t count_growing(const Eigenvalues& eigenvalues) {
    const double threshold = growth_tolerance * find_size(eigenvalues);
    return static_cast<std::size_t>(std::count_if(eigenvalues.begin(), eigenvalues.end(),
                                                  [&](const auto& value) { return value.real() > threshold; }));
  }

  // Stability.

  void find_stability_changes(const SweepPoint& low, const SweepPoint& high) {
    if (low.modes.eigenvalues.size() != high.modes.eigenvalues.size()) return;
    const std::ptrdiff_t zeros = std::min(count_zeros(low.modes.eigenvalues), count_zeros(high.modes.eigenvalues));
    const Eigenvalues a = without_smallest(low.modes.eigenvalues, zeros),
                      b = without_smallest(high.modes.eigenvalues, zeros);
    if (a.empty()) return;
    const std::size_t first = count_growing(a), last = count_growing(b);
    // an oscillation is a pair
    for (std::size_t m = std::min(first, last); m < std::max(first, last);) {
      const double value = find_crossing(low.value, high.value, a, b, m, zeros);
      const Eigenvalues there = without_smallest(eigenvalues_at(value), zeros);
      if (there.size() != a.size()) return;
      const std::complex<double> crossing = there[m];
      sweep_.stability_changes.push_back({value, last > first, {crossing.real(), std::abs(crossing.imag())}});
      m += std::abs(crossing.imag()) > growth_tolerance * find_size(there) ? 2 : 1;
    }
  }

  /// The root of the inverse cubic through points on both sides of a root: nearer to it, an eigenvalue that passes through
  /// zero cannot be told from those of rigid motions, which are zero but for round-off.
  template <class Function>
  static double interpolate_root(const Function& real_part, double root, double low, double high) {
    const double step = interpolation_step * (high - low);
    if (root - 2 * step < low || root + 2 * step > high) return root;
    const std::array<double, 4> values{root - 2 * step, root - step, root + step, root + 2 * step};
    std::array<double, 4> parts{};
    std::transform(values.begin(), values.end(), parts.begin(), real_part);
    double result = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      double weight = 1;
      for (std::size_t j = 0; j < values.size(); ++j)
        if (j != i) weight *= parts[j] / (parts[j] - parts[i]);
      result += weight * (values[i] - root);
    }
    return std::abs(result) <= step ? root + result : root;
  }

  /// Where the m-th largest real part passes through zero.
  double find_crossing(double low, double high, const Eigenvalues& a, const Eigenvalues& b, std::size_t m,
                       std::ptrdiff_t zeros) const {
    const auto real_part = [&](double value) {
      const Eigenvalues eigenvalues = without_smallest(eigenvalues_at(value), zeros);
      if (m >= eigenvalues.size()) throw std::invalid_argument("the motion cannot be linearised within the sweep");
      return eigenvalues[m].real();
    };
    const double fa = a[m].real(), fb = b[m].real();
    const double threshold = growth_tolerance * std::max(find_size(a), find_size(b));
    if ((fa > threshold && fb < -threshold) || (fa < -threshold && fb > threshold))
      return interpolate_root(real_part, numerics::find_bracketed_root(real_part, low, high, fa, fb, root_tolerance),
                              low, high);
    // without damping the real part is zero on one side
    const bool grows_below = fa > threshold;
    while (high - low > bisection_tolerance * std::max(std::abs(low), std::abs(high))) {
      const double middle = (low + high) / 2;
      ((real_part(middle) > threshold) == grows_below ? low : high) = middle;
    }
    return (low + high) / 2;
  }

  // Critical speeds.

  static std::vector<const VibrationMode*> list_oscillations(const VibrationModes& modes) {
    std::vector<const VibrationMode*> list;
    for (const VibrationMode& mode : modes.modes)
      if (mode.oscillates()) list.push_back(&mode);
    std::sort(list.begin(), list.end(), [](const VibrationMode* a, const VibrationMode* b) {
      return a->eigenvalue.imag() < b->eigenvalue.imag();
    });
    return list;
  }

  void find_critical_speeds(const SweepPoint& low, const SweepPoint& high) {
    if (!low.response || !high.response) return;
    const auto modes_below = list_oscillations(low.modes), modes_above = list_oscillations(high.modes);
    for (std::size_t k = 0; k < std::min(modes_below.size(), modes_above.size()); ++k)
      for (const double order : low.response->orders) {
        const double fa = order * std::abs(low.response->turning.speed) - modes_below[k]->eigenvalue.imag(),
                     fb = order * std::abs(high.response->turning.speed) - modes_above[k]->eigenvalue.imag();
        if (fa == 0 ? fb == 0 : (fa > 0) == (fb > 0)) continue;
        add_critical_speed(low, high, k, order, fa, fb);
      }
  }

  void add_critical_speed(const SweepPoint& low, const SweepPoint& high, std::size_t k, double order, double fa,
                          double fb) {
    VibrationMode mode;
    const auto difference = [&](double value) {
      const SweptCase swept = case_at_(value);
      const VibrationModes modes = find_vibration_modes(swept.mechanism, &*swept.trajectory);
      const auto oscillations = list_oscillations(modes);
      const auto turning = find_driven_turning(swept.mechanism, *swept.trajectory);
      if (k >= oscillations.size() || !turning) return 0.0;
      mode = *oscillations[k];
      return order * std::abs(turning->speed) - mode.eigenvalue.imag();
    };
    const double value = numerics::find_bracketed_root(difference, low.value, high.value, fa, fb, bisection_tolerance);
    difference(value);
    const auto same = [&](const CriticalSpeed& other) {
      return other.order == order && std::abs(other.value - value) <= 1e-6 * std::abs(value);
    };
    if (std::none_of(sweep_.critical_speeds.begin(), sweep_.critical_speeds.end(), same))
      sweep_.critical_speeds.push_back({value, order, mode.frequency(), mode.damping_ratio()});
  }

  const std::function<SweptCase(double)>& case_at_;
  const SweepOptions& options_;
  SpeedSweep sweep_;
};

}  // namespace

SpeedSweep sweep_speeds(const std::function<SweptCase(double value)>& case_at, const SweepOptions& options,
                        const simulation::Progress& progress) {
  return SpeedSweeper(case_at, options).run(progress);
}

Trajectory change_speed(const Trajectory& trajectory, const results::UniformTurning& turning, double speed) {
  Trajectory changed = trajectory;
  changed.duration *= turning.speed / speed;
  return changed;
}

}  // namespace balance::vibration
