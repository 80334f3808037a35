#pragma once
/// A force as a table over a displacement: tension over length, or effort over a joint coordinate.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace balance::model {

/// How a table is read between its rows. Beyond the first and last row the force is that of this row.
enum class TableInterpolation {
  linear,
  spline  ///< C² cubic spline (not-a-knot) through at least four rows
};

/// Rows of a table; without rows there is none.
template <class T>
struct ForceTableOf {
  std::vector<T> displacement;  ///< increasing [m] or [rad]
  std::vector<T> force;         ///< one per displacement [N] or [N m]
  TableInterpolation interpolation = TableInterpolation::linear;

  bool is_empty() const { return force.empty(); }
  template <class To, class Number>
  ForceTableOf<To> convert(const Number& number) const {
    ForceTableOf<To> converted{{}, {}, interpolation};
    for (const T& x : displacement) converted.displacement.push_back(number(x));
    for (const T& f : force) converted.force.push_back(number(f));
    return converted;
  }
};

/// The function that a table describes, and its integral. Over duals also its derivatives by the rows.
template <class T>
class ForceLawOf {
 public:
  ForceLawOf() = default;
  /// @param table valid (validate()) and not empty
  explicit ForceLawOf(const ForceTableOf<T>& table) : table_(table) {
    if (table.interpolation == TableInterpolation::spline) slope_ = solve_not_a_knot_slopes();
    energy_.assign(table.force.size(), T(0));
    for (std::size_t k = 1; k < energy_.size(); ++k)
      energy_[k] = energy_[k - 1] + integrate_interval(k - 1, width(k - 1));
  }

  T force(const T& displacement) const {
    const std::vector<T>&x = table_.displacement, &f = table_.force;
    if (!(displacement > x.front())) return f.front();
    if (!(displacement < x.back())) return f.back();
    const std::size_t k = find_interval(displacement);
    const T h = width(k), t = (displacement - x[k]) / h;
    if (slope_.empty()) return f[k] + t * (f[k + 1] - f[k]);
    return f[k] + t * (h * slope_[k] + t * (quadratic(k) + t * cubic(k)));
  }

  /// Largest magnitude in the table.
  T max_force() const {
    T largest = 0;
    for (const T& f : table_.force)
      if (f > largest || -f > largest) largest = f > 0 ? f : T(-f);
    return largest;
  }

  /// ∫ force d(displacement) from the first row [J].
  T energy(const T& displacement) const {
    const std::vector<T>&x = table_.displacement, &f = table_.force;
    if (!(displacement > x.front())) return f.front() * (displacement - x.front());
    if (!(displacement < x.back())) return energy_.back() + f.back() * (displacement - x.back());
    const std::size_t k = find_interval(displacement);
    return energy_[k] + integrate_interval(k, displacement - x[k]);
  }

 private:
  T width(std::size_t k) const { return table_.displacement[k + 1] - table_.displacement[k]; }
  T secant(std::size_t k) const { return (table_.force[k + 1] - table_.force[k]) / width(k); }
  std::size_t find_interval(const T& displacement) const {
    const std::vector<T>& x = table_.displacement;
    return static_cast<std::size_t>(std::upper_bound(x.begin() + 1, x.end() - 1, displacement) - x.begin()) - 1;
  }
  // Coefficients of the cubic of an interval in t, 0 to 1: Hermite's.
  T quadratic(std::size_t k) const {
    return 3 * (table_.force[k + 1] - table_.force[k]) - width(k) * (2 * slope_[k] + slope_[k + 1]);
  }
  T cubic(std::size_t k) const {
    return 2 * (table_.force[k] - table_.force[k + 1]) + width(k) * (slope_[k] + slope_[k + 1]);
  }
  T integrate_interval(std::size_t k, const T& distance) const {
    const T h = width(k), t = distance / h, start = table_.force[k];
    if (slope_.empty()) return distance * (start + 0.5 * t * (table_.force[k + 1] - start));
    return distance * (start + t * (0.5 * h * slope_[k] + t * (quadratic(k) / 3 + 0.25 * t * cubic(k))));
  }

  /// The second derivative is continuous, and so is the third at the second and the last but one row
  /// (C. de Boor, A Practical Guide to Splines, ch. IV): a tridiagonal system for the slopes.
  std::vector<T> solve_not_a_knot_slopes() const {
    const std::size_t last = table_.force.size() - 1;
    std::vector<T> lower(last + 1, T(0)), diagonal(last + 1, T(0)), upper(last + 1, T(0)), slope(last + 1, T(0));
    const T first_two = width(0) + width(1), last_two = width(last - 1) + width(last - 2);
    diagonal[0] = width(1), upper[0] = first_two;
    slope[0] = ((width(0) + 2 * first_two) * width(1) * secant(0) + width(0) * width(0) * secant(1)) / first_two;
    for (std::size_t k = 1; k < last; ++k) {
      lower[k] = width(k), diagonal[k] = 2 * (width(k - 1) + width(k)), upper[k] = width(k - 1);
      slope[k] = 3 * (width(k) * secant(k - 1) + width(k - 1) * secant(k));
    }
    diagonal[last] = width(last - 2), lower[last] = last_two;
    slope[last] = (width(last - 1) * width(last - 1) * secant(last - 2) +
                   (2 * last_two + width(last - 1)) * width(last - 2) * secant(last - 1)) /
                  last_two;
    for (std::size_t k = 1; k <= last; ++k) {
      const T factor = lower[k] / diagonal[k - 1];
      diagonal[k] -= factor * upper[k - 1];
      slope[k] -= factor * slope[k - 1];
    }
    slope[last] /= diagonal[last];
    for (std::size_t k = last; k-- > 0;) slope[k] = (slope[k] - upper[k] * slope[k + 1]) / diagonal[k];
    return slope;
  }

  ForceTableOf<T> table_;
  std::vector<T> slope_;   ///< of a spline, at the rows
  std::vector<T> energy_;  ///< at the rows
};

}  // namespace balance::model
