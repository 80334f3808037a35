#pragma once
/// Functions of one parameter as Chebyshev series on panels.

#include "balance/foundation/base/types.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace balance::numerics {

/// An interval of the parameter and the series of every function on it.
struct Panel {
  double begin = 0, end = 1;
  Samples coefficients;  ///< one row per term, one column per function
};

/// Their integrals, zero at the beginning of the panel; see PiecewiseChebyshevSeries::integral().
Panel integrate(const Panel& panel);

/// Values at the Chebyshev points of the panel: one row per point.
Samples values_at_chebyshev_points(const Panel& panel);

/// Several functions of one parameter. Immutable; evaluation allocates nothing.
class PiecewiseChebyshevSeries {
 public:
  static constexpr int coefficient_count = 16;

  PiecewiseChebyshevSeries() = default;
  /// @param panels in order, each beginning where the previous one ends
  explicit PiecewiseChebyshevSeries(std::vector<Panel> panels) : panels_(std::move(panels)) {}

  const std::vector<Panel>& panels() const { return panels_; }
  Eigen::Index function_count() const { return panels_.empty() ? 0 : panels_.front().coefficients.cols(); }

  /// The panel in [first, last) that contains a parameter.
  std::size_t find_panel(double parameter, std::size_t first, std::size_t last) const;

  /// Values of all functions from one panel's series, extrapolated beyond its ends. @param out function_count() entries
  void evaluate(std::size_t panel, double parameter, double* out) const;

  /// The derivatives of the functions with respect to the parameter.
  PiecewiseChebyshevSeries derivative() const;

  /// Their integrals from the start of the first panel. The additional term is dropped: it is negligible in a converged
  /// series.
  PiecewiseChebyshevSeries integral() const;

  /// Chebyshev points of the first kind on [−1, 1], increasing with k < coefficient_count. They exclude the ends, where
  /// functions may jump.
  static double chebyshev_point(int k);
  using Transform = Eigen::Matrix<double, coefficient_count, coefficient_count>;
  /// Maps values at the points to coefficients.
  static const Transform& values_to_coefficients();

 private:
  std::vector<Panel> panels_;
};

}  // namespace balance::numerics
