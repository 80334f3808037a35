#include "balance/motion/time_optimal/acceleration_limits.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::time_optimal {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Bounds hold up to round-off.
constexpr double relative_bound_epsilon = 1e-12;

/// Accuracy of located zeros of a, as a fraction of its maximum.
constexpr double zero_inertia_tolerance = 1e-7;

/// Larger values count as infinite.
constexpr double max_squared_rate = 1e60;

void raise_lower_bound(AccelerationInterval& interval, double low, int row) {
  if (low > interval.lower) interval.lower = low, interval.lower_row = row;
}

void reduce_upper_bound(AccelerationInterval& interval, double high, int row) {
  if (high < interval.upper) interval.upper = high, interval.upper_row = row;
}

void make_empty(AccelerationInterval& interval) {
  interval.lower = infinite;
  interval.upper = -infinite;
}

/// The smallest positive root of b v² + d v + c with c ≤ 0, or infinity.
double find_smallest_positive_root(double b, double d, double c) {
  const double discriminant = d * d - 4 * b * c;
  if (discriminant < 0) return infinite;
  const double q = -(d + std::copysign(std::sqrt(discriminant), d)) / 2;
  double root = infinite;
  for (const double candidate : {b != 0 ? q / b : infinite, q != 0 ? c / q : infinite})
    if (candidate > 0 && candidate < root) root = candidate;
  return root;
}

}  // namespace

AccelerationLimits::AccelerationLimits(const PathModel& model, const std::vector<double>& bounds)
    : model_(model), bounds_(bounds), values_(model.value.function_count()), scratch_(values_.size()) {
  dropped_.assign(model.rows.size(), 0);
}

void AccelerationLimits::move_to(double s, std::size_t first_panel, std::size_t last_panel) {
  ++evaluations_;
  s_ = s;
  panel_ = model_.value.find_panel(s, first_panel, last_panel);
  model_.value.evaluate(panel_, s, values_.data());
  std::fill(dropped_.begin(), dropped_.end(), 0);
}

bool AccelerationLimits::drop_zero_inertia_rows() {
  bool is_any_dropped = false;
  for (std::size_t r = 0; r < dropped_.size(); ++r) {
    const PathConstraintRow& row = model_.rows[r];
    if (!row.has_acceleration_term) continue;
    const double max_norm = numerics::max_abs(model_.max_magnitude.segment(row.a, row.count));
    dropped_[r] = values_.segment(row.a, row.count).norm() <= zero_inertia_tolerance * max_norm;
    is_any_dropped = is_any_dropped || dropped_[r] != 0;
  }
  return is_any_dropped;
}

bool AccelerationLimits::is_velocity_row(int row) const {
  return !model_.rows[static_cast<std::size_t>(row)].has_acceleration_term || is_dropped(row);
}

/// |a u + r| ≤ bound with r = b x + c + d v − centre.
void AccelerationLimits::apply_scalar_row(const PathConstraintRow& row, double bound, double x, double v, int index,
                                          AccelerationInterval& interval) const {
  const double a = value(row.a, 0), r = value_without_acceleration(row, 0, x, v);
  if (a == 0) {
    if (std::abs(r) > bound * (1 + relative_bound_epsilon)) make_empty(interval);
    return;
  }
  const double first = (-bound - r) / a, second = (bound - r) / a;
  raise_lower_bound(interval, std::min(first, second), index);
  reduce_upper_bound(interval, std::max(first, second), index);
}

/// |a u + r|² ≤ bound² is a quadratic inequality for u.
void AccelerationLimits::apply_vector_row(const PathConstraintRow& row, double bound, double x, double v, int index,
                                          AccelerationInterval& interval) const {
  double aa = 0, ar = 0, rr = 0;
  for (int i = 0; i < row.count; ++i) {
    const double a = value(row.a, i), r = value_without_acceleration(row, i, x, v);
    aa += a * a;
    ar += a * r;
    rr += r * r;
  }
  const double excess = rr - bound * bound;
  if (aa == 0) {
    if (excess > 2 * relative_bound_epsilon * bound * bound) make_empty(interval);
    return;
  }
  const double discriminant = ar * ar - aa * excess;
  if (discriminant < 0) return make_empty(interval);
  const double root = std::sqrt(discriminant);
  raise_lower_bound(interval, (-ar - root) / aa, index);
  reduce_upper_bound(interval, (-ar + root) / aa, index);
}

AccelerationInterval AccelerationLimits::bounds(double x) const {
  AccelerationInterval interval = bounds_by_acceleration_rows(x);
  const VelocityBound velocity_bound = direct_velocity_bound();
  if (x > velocity_bound.x * (1 + relative_bound_epsilon)) make_empty(interval);
  return interval;
}

AccelerationInterval AccelerationLimits::bounds_by_acceleration_rows(double x) const {
  AccelerationInterval interval{-infinite, infinite, -1, -1};
  const double v = std::sqrt(x);
  for (std::size_t r = 0; r < model_.rows.size(); ++r) {
    const PathConstraintRow& row = model_.rows[r];
    const auto index = static_cast<int>(r);
    if (is_velocity_row(index)) continue;
    if (row.count == 1)
      apply_scalar_row(row, bounds_[r], x, v, index, interval);
    else
      apply_vector_row(row, bounds_[r], x, v, index, interval);
  }
  return interval;
}

double AccelerationLimits::velocity_bound_of_scalar(const PathConstraintRow& row, double bound) const {
  const double b = value(row.b, 0), c = value(row.c, 0) - row.centre, d = value(row.d, 0);
  if (std::abs(c) > bound) return 0;
  const double v =
      std::min(find_smallest_positive_root(b, d, c - bound), find_smallest_positive_root(-b, -d, -c - bound));
  return v * v;
}

double AccelerationLimits::direct_velocity_bound_of(int index) const {
  const PathConstraintRow& row = model_.rows[static_cast<std::size_t>(index)];
  const double bound = bounds_[static_cast<std::size_t>(index)];
  if (row.count == 1) return velocity_bound_of_scalar(row, bound);
  const auto is_feasible = [&](double v) {
    double squared_norm = 0;
    for (int i = 0; i < row.count; ++i) {
      const double r = value_without_acceleration(row, i, v * v, v);
      squared_norm += r * r;
    }
    return squared_norm <= bound * bound;
  };
  double low = 0, high = 1;
  if (!is_feasible(low)) return 0;
  while (is_feasible(high)) {
    low = high;
    high *= 4;
    if (high * high > max_squared_rate) return infinite;
  }
  for (int halving = 0; halving < 200 && high - low > 1e-15 * high; ++halving) {
    const double middle = (low + high) / 2;
    (is_feasible(middle) ? low : high) = middle;
  }
  return low * low;
}

VelocityBound AccelerationLimits::direct_velocity_bound() const {
  VelocityBound lowest{infinite, -1};
  for (std::size_t r = 0; r < model_.rows.size(); ++r) {
    const auto index = static_cast<int>(r);
    if (!is_velocity_row(index)) continue;
    const double x = direct_velocity_bound_of(index);
    if (x < lowest.x) lowest = {x, index};
  }
  return lowest;
}

VelocityBound AccelerationLimits::max_velocity(double guess) const {
  const VelocityBound velocity_bound = direct_velocity_bound();
  if (std::isfinite(velocity_bound.x) && !bounds(velocity_bound.x * (1 - relative_bound_epsilon)).is_empty())
    return velocity_bound;
  double low = 0, high = std::min(velocity_bound.x, guess > 0 ? 1.01 * guess : 1);
  if (guess > 0 && !bounds(0.99 * guess).is_empty()) low = 0.99 * guess;
  while (!bounds(high).is_empty()) {
    low = high;
    high = std::min(velocity_bound.x, 2 * high);
    if (high > max_squared_rate) return {infinite, -1};
  }
  while (low == 0 && high > 1 / max_squared_rate) {  // find the order of magnitude
    if (!bounds(high / 16).is_empty())
      low = high / 16;
    else
      high /= 16;
  }
  for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
    const double middle = (low + high) / 2;
    (bounds(middle).is_empty() ? high : low) = middle;
  }
  return {low, -1};
}

AccelerationLimits::ProjectedCoefficients AccelerationLimits::project(const numerics::PiecewiseChebyshevSeries& series,
                                                                      int index, double x) const {
  const PathConstraintRow& row = model_.rows[static_cast<std::size_t>(index)];
  const double v = std::sqrt(x);
  VectorX direction(row.count);
  for (int i = 0; i < row.count; ++i) direction[i] = value_without_acceleration(row, i, x, v);
  direction.normalize();
  series.evaluate(panel_, s_, scratch_.data());
  const auto component = [&](int column) {
    return column < 0 ? 0.0 : direction.dot(scratch_.segment(column, row.count));
  };
  return {row.has_acceleration_term ? component(row.a) : 0, component(row.b), component(row.c), component(row.d)};
}

double AccelerationLimits::zero_inertia_slope(int row, double x) const {
  const ProjectedCoefficients current = project(model_.value, row, x), first = project(model_.first, row, x);
  return first.a + 2 * current.b + (current.d == 0 ? 0 : current.d / std::sqrt(x));
}

double AccelerationLimits::acceleration_on_bound(int row, double x) const {
  const ProjectedCoefficients first = project(model_.first, row, x);
  return -(first.b * x + first.c + first.d * std::sqrt(x)) / zero_inertia_slope(row, x);
}

double AccelerationLimits::acceleration_slope_on_bound(int row, double x, double u) const {
  const ProjectedCoefficients current = project(model_.value, row, x), first = project(model_.first, row, x);
  const ProjectedCoefficients second = project(model_.second, row, x);
  const double v = std::sqrt(x), friction_slope = current.d == 0 ? 0 : current.d / v;
  const double numerator = second.a * u + second.b * x + 4 * first.b * u + second.c + second.d * v +
                           2 * first.d * u / v - friction_slope * u * u / x;
  return -numerator / (2 * first.a + 2 * current.b + friction_slope);
}

double AccelerationLimits::magnitude(int index, double x, double u) const {
  const PathConstraintRow& row = model_.rows[static_cast<std::size_t>(index)];
  const double v = std::sqrt(x);
  double squared_norm = 0;
  for (int i = 0; i < row.count; ++i) {
    const double r = value(row.a, i) * u + value_without_acceleration(row, i, x, v);
    squared_norm += r * r;
  }
  return std::sqrt(squared_norm);
}

}  // namespace balance::time_optimal
