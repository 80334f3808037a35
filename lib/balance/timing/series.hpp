#pragma once
/// Functions of one parameter as Chebyshev series on panels. Private to timing.

#include "balance/base/types.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace balance {

/// A stretch of the parameter, and the series of every function on it.
struct Panel {
  double begin = 0, end = 1;
  Samples terms;  ///< one row per term, one column per function
};

/// Several functions of one parameter. Immutable; evaluation allocates nothing.
class PiecewiseSeries {
 public:
  static constexpr int terms = 16;

  PiecewiseSeries() = default;
  /// @param panels in order, each beginning where the one before ends
  explicit PiecewiseSeries(std::vector<Panel> panels) : panels_(std::move(panels)) {}

  const std::vector<Panel>& panels() const { return panels_; }
  Eigen::Index functions() const { return panels_.empty() ? 0 : panels_.front().terms.cols(); }

  /// The panel that holds a parameter within [first, last).
  std::size_t panel_at(double parameter, std::size_t first, std::size_t last) const;

  /// Values of all functions by one panel's series, which go on beyond its ends. @param out functions() entries
  void at(std::size_t panel, double parameter, double* out) const;

  /// The derivatives of the functions.
  PiecewiseSeries derivative() const;

 private:
  std::vector<Panel> panels_;
};

/// Values of all functions at increasing parameters, one row each. @return false if they cannot be had
using SampleFunctions = std::function<bool(const std::vector<double>& parameters, Samples& rows)>;

/// What a series is good for: where it ends, its last terms are so much smaller than the largest value on the panel.
inline constexpr double series_tolerance = 1e-10;

enum class FitStatus { done, not_sampled, too_rough };

/// Fits panels to functions that are smooth between stations, halving panels until their series end.
/// @param stations increasing, at least two: the ends and where functions may jump
/// @param floor per function: smaller values are noise
FitStatus fit_series(const std::vector<double>& stations, const VectorX& floor, const SampleFunctions& sample,
                     PiecewiseSeries& series);

}  // namespace balance
