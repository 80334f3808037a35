#pragma once
/// The value of a run's figure to be expected of mechanisms whose numbers deviate: its mean plus a multiple of its
/// standard deviation. docs/theory.md, section 11.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include <string>
#include <vector>

namespace balance::tolerance {

/// For an rms or a mean, the mean uses expected squares, f² + Σ (∂f/∂x σ)², at every instant: it is nonzero where f
/// vanishes only at the nominal numbers. The deviation is the first-order deviation of those squares. For a peak, the
/// mean is |f| at the instant at which |f| + kσ is maximum, with σ that of the sample (for a vector, the root of the
/// sum of its components' squares). For a range, it is f(s) − f(t) at the instants at which f(s) − f(t) + kσ is
/// maximum, with σ that of the difference.
struct RobustFigure {
  double nominal = 0;  ///< the figure with nominal numbers
  double mean = 0, deviation = 0;
  double value = 0;                                            ///< mean + k deviation
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< numbers that are left out
};

/// The tolerances at the current inputs of the space: relative widths follow the values.
Tolerances evaluate_tolerances(const DesignSpace& space);

/// @param term a figure with deviations
/// @param x values of space.start.free_numbers
/// @return NaN if the motion is impossible
/// @throws std::invalid_argument as analyse_tolerance, and if the run does not have the quantity
RobustFigure compute_robust_figure(const DesignSpace& space, const VectorX& x, const ObjectiveTerm& term);

/// A robust figure in the objective of a design.
struct RobustTerm {
  ObjectiveTerm term;
  RobustFigure figure;
};

/// @return those of the terms that are robust figures
std::vector<RobustTerm> robust_terms(const DesignSpace& space, const VectorX& x,
                                     const std::vector<ObjectiveTerm>& terms);

}  // namespace balance::tolerance
