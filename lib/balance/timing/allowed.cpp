#include "balance/timing/allowed.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// What holds to round-off holds.
constexpr double round_off = 1e-12;

/// A zero of a that was searched for is met so well, as a part of its largest value.
constexpr double met_zero = 1e-7;

/// Larger ones are none.
constexpr double largest_x = 1e60;

void raise(Interval& interval, double low, int row) {
  if (low > interval.low) interval.low = low, interval.low_row = row;
}

void lower(Interval& interval, double high, int row) {
  if (high < interval.high) interval.high = high, interval.high_row = row;
}

void close(Interval& interval) {
  interval.low = infinite;
  interval.high = -infinite;
}

/// The smallest positive root of b v² + d v + c with c ≤ 0, or infinity.
double first_root(double b, double d, double c) {
  const double discriminant = d * d - 4 * b * c;
  if (discriminant < 0) return infinite;
  const double q = -(d + std::copysign(std::sqrt(discriminant), d)) / 2;
  double root = infinite;
  for (const double one : {b != 0 ? q / b : infinite, q != 0 ? c / q : infinite})
    if (one > 0 && one < root) root = one;
  return root;
}

}  // namespace

Allowed::Allowed(const PathModel& model, const std::vector<double>& bounds)
    : model_(model), bounds_(bounds), values_(model.value.functions()), scratch_(values_.size()) {
  dropped_.assign(model.rows.size(), 0);
}

void Allowed::go(double place, std::size_t first_panel, std::size_t last_panel) {
  ++looks_;
  place_ = place;
  panel_ = model_.value.panel_at(place, first_panel, last_panel);
  model_.value.at(panel_, place, values_.data());
  std::fill(dropped_.begin(), dropped_.end(), 0);
}

bool Allowed::drop_inertia() {
  bool any = false;
  for (std::size_t r = 0; r < dropped_.size(); ++r) {
    const LimitRow& row = model_.rows[r];
    if (!row.limits_acceleration) continue;
    const double most = max_abs(model_.largest.segment(row.a, row.count));
    dropped_[r] = values_.segment(row.a, row.count).norm() <= met_zero * most;
    any = any || dropped_[r] != 0;
  }
  return any;
}

bool Allowed::without_a(int row) const {
  return !model_.rows[static_cast<std::size_t>(row)].limits_acceleration || has_dropped(row);
}

/// |a u + r| ≤ bound with r = b x + c + d v − middle.
void Allowed::cut_scalar(const LimitRow& row, double bound, double x, double v, int index, Interval& interval) const {
  const double a = value(row.a, 0), r = without_inertia(row, 0, x, v);
  if (a == 0) {
    if (std::abs(r) > bound * (1 + round_off)) close(interval);
    return;
  }
  const double first = (-bound - r) / a, second = (bound - r) / a;
  raise(interval, std::min(first, second), index);
  lower(interval, std::max(first, second), index);
}

/// |a u + r|² ≤ bound² is a quadratic inequality for u.
void Allowed::cut_vector(const LimitRow& row, double bound, double x, double v, int index, Interval& interval) const {
  double aa = 0, ar = 0, rr = 0;
  for (int i = 0; i < row.count; ++i) {
    const double a = value(row.a, i), r = without_inertia(row, i, x, v);
    aa += a * a;
    ar += a * r;
    rr += r * r;
  }
  const double excess = rr - bound * bound;
  if (aa == 0) {
    if (excess > 2 * round_off * bound * bound) close(interval);
    return;
  }
  const double discriminant = ar * ar - aa * excess;
  if (discriminant < 0) return close(interval);
  const double root = std::sqrt(discriminant);
  raise(interval, (-ar - root) / aa, index);
  lower(interval, (-ar + root) / aa, index);
}

Interval Allowed::at(double x) const {
  Interval interval = by_inertia(x);
  const Ceiling most = cap();
  if (x > most.x * (1 + round_off)) close(interval);
  return interval;
}

Interval Allowed::by_inertia(double x) const {
  Interval interval{-infinite, infinite, -1, -1};
  const double v = std::sqrt(x);
  for (std::size_t r = 0; r < model_.rows.size(); ++r) {
    const LimitRow& row = model_.rows[r];
    const auto index = static_cast<int>(r);
    if (without_a(index)) continue;
    if (row.count == 1)
      cut_scalar(row, bounds_[r], x, v, index, interval);
    else
      cut_vector(row, bounds_[r], x, v, index, interval);
  }
  return interval;
}

double Allowed::cap_of_scalar(const LimitRow& row, double bound) const {
  const double b = value(row.b, 0), c = value(row.c, 0) - row.middle, d = value(row.d, 0);
  if (std::abs(c) > bound) return 0;
  const double v = std::min(first_root(b, d, c - bound), first_root(-b, -d, -c - bound));
  return v * v;
}

double Allowed::cap_of(int index) const {
  const LimitRow& row = model_.rows[static_cast<std::size_t>(index)];
  const double bound = bounds_[static_cast<std::size_t>(index)];
  if (row.count == 1) return cap_of_scalar(row, bound);
  const auto inside = [&](double v) {
    double square = 0;
    for (int i = 0; i < row.count; ++i) {
      const double r = without_inertia(row, i, v * v, v);
      square += r * r;
    }
    return square <= bound * bound;
  };
  double low = 0, high = 1;
  if (!inside(low)) return 0;
  while (inside(high)) {
    low = high;
    high *= 4;
    if (high * high > largest_x) return infinite;
  }
  for (int halving = 0; halving < 200 && high - low > 1e-15 * high; ++halving) {
    const double middle = (low + high) / 2;
    (inside(middle) ? low : high) = middle;
  }
  return low * low;
}

Ceiling Allowed::cap() const {
  Ceiling ceiling{infinite, -1};
  for (std::size_t r = 0; r < model_.rows.size(); ++r) {
    const auto index = static_cast<int>(r);
    if (!without_a(index)) continue;
    const double x = cap_of(index);
    if (x < ceiling.x) ceiling = {x, index};
  }
  return ceiling;
}

Ceiling Allowed::ceiling(double guess) const {
  const Ceiling capped = cap();
  if (std::isfinite(capped.x) && !at(capped.x * (1 - round_off)).empty()) return capped;
  double low = 0, high = std::min(capped.x, guess > 0 ? 1.01 * guess : 1);
  if (guess > 0 && !at(0.99 * guess).empty()) low = 0.99 * guess;
  while (!at(high).empty()) {
    low = high;
    high = std::min(capped.x, 2 * high);
    if (high > largest_x) return {infinite, -1};
  }
  while (low == 0 && high > 1 / largest_x) {  // down to its order of magnitude
    if (!at(high / 16).empty())
      low = high / 16;
    else
      high /= 16;
  }
  for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
    const double middle = (low + high) / 2;
    (at(middle).empty() ? high : low) = middle;
  }
  return {low, -1};
}

Allowed::Projected Allowed::project(const PiecewiseSeries& series, int index, double x) const {
  const LimitRow& row = model_.rows[static_cast<std::size_t>(index)];
  const double v = std::sqrt(x);
  VectorX direction(row.count);
  for (int i = 0; i < row.count; ++i) direction[i] = without_inertia(row, i, x, v);
  direction.normalize();
  series.at(panel_, place_, scratch_.data());
  const auto along = [&](int column) { return column < 0 ? 0.0 : direction.dot(scratch_.segment(column, row.count)); };
  return {row.limits_acceleration ? along(row.a) : 0, along(row.b), along(row.c), along(row.d)};
}

double Allowed::steepness(int row, double x) const {
  const Projected now = project(model_.value, row, x), first = project(model_.first, row, x);
  return first.a + 2 * now.b + (now.d == 0 ? 0 : now.d / std::sqrt(x));
}

double Allowed::along(int row, double x) const {
  const Projected first = project(model_.first, row, x);
  return -(first.b * x + first.c + first.d * std::sqrt(x)) / steepness(row, x);
}

double Allowed::bend_along(int row, double x, double u) const {
  const Projected now = project(model_.value, row, x), first = project(model_.first, row, x);
  const Projected second = project(model_.second, row, x);
  const double v = std::sqrt(x), rub = now.d == 0 ? 0 : now.d / v;
  const double above =
      second.a * u + second.b * x + 4 * first.b * u + second.c + second.d * v + 2 * first.d * u / v - rub * u * u / x;
  return -above / (2 * first.a + 2 * now.b + rub);
}

double Allowed::magnitude(int index, double x, double u) const {
  const LimitRow& row = model_.rows[static_cast<std::size_t>(index)];
  const double v = std::sqrt(x);
  double square = 0;
  for (int i = 0; i < row.count; ++i) {
    const double r = value(row.a, i) * u + without_inertia(row, i, x, v);
    square += r * r;
  }
  return std::sqrt(square);
}

}  // namespace balance
