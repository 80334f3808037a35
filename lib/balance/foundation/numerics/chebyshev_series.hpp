#pragma once
/// Functions of one parameter as Chebyshev series on panels.

#include "balance/foundation/base/types.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace balance {

/// A stretch of the parameter, and the series of every function on it.
struct Panel {
  double begin = 0, end = 1;
  Samples coefficients;  ///< one row per term, one column per function
};

/// Several functions of one parameter. Immutable; evaluation allocates nothing.
class PiecewiseChebyshevSeries {
 public:
  static constexpr int coefficient_count = 16;

  PiecewiseChebyshevSeries() = default;
  /// @param panels in order, each beginning where the one before ends
  explicit PiecewiseChebyshevSeries(std::vector<Panel> panels) : panels_(std::move(panels)) {}

  const std::vector<Panel>& panels() const { return panels_; }
  Eigen::Index function_count() const { return panels_.empty() ? 0 : panels_.front().coefficients.cols(); }

  /// The panel that holds a parameter within [first, last).
  std::size_t find_panel(double parameter, std::size_t first, std::size_t last) const;

  /// Values of all functions by one panel's series, which go on beyond its ends. @param out functions() entries
  void evaluate(std::size_t panel, double parameter, double* out) const;

  /// The derivatives of the functions with respect to the parameter.
  PiecewiseChebyshevSeries derivative() const;

  /// Their integrals from the first panel's beginning on. What a further term would add is left out: series end before.
  PiecewiseChebyshevSeries integral() const;

  /// Chebyshev's points of the first kind on [−1, 1], increasing with k < terms: the ends, where functions may jump, are none of them.
  static double chebyshev_point(int k);
  using Transform = Eigen::Matrix<double, coefficient_count, coefficient_count>;
  /// From values at the points to terms.
  static const Transform& values_to_coefficients();

 private:
  std::vector<Panel> panels_;
};

}  // namespace balance
