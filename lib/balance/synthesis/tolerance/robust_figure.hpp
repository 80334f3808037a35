#pragma once
/// A figure of a run as it is to be expected of mechanisms whose numbers are off: its mean plus some of its deviations. docs/theory.md,
/// section 11.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include <string>
#include <vector>

namespace balance {

/// Of an rms or a mean the mean is made of expected squares, f² + Σ (∂f/∂x σ)², at every moment: it is not zero where f vanishes but for
/// the numbers that are off, and the deviation is the first order one of those squares. Of a peak it is |f| where |f| + kσ is largest over
/// the run, σ being that of the sample (of a vector the root of the sum of its components' squares). Of a range it is f(s) − f(t) where
/// f(s) − f(t) + kσ is, σ being that of the difference.
struct RobustFigure {
  double nominal = 0;  ///< the figure where no number is off
  double mean = 0, deviation = 0;
  double value = 0;                                            ///< mean + k deviation
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< numbers that are left out
};

/// The numbers as they are where the space has its inputs: percentages follow values.
Tolerances evaluate_tolerances(const DesignSpace& space);

/// @param term a figure with deviations @param x values of space.start.free_numbers
/// @return NaN where the motion cannot be made
/// @throws std::invalid_argument as tolerance(), and if the run does not have the quantity
RobustFigure compute_robust_figure(const DesignSpace& space, const VectorX& x, const ObjectiveTerm& term);

/// A robust figure among those that a design was made for.
struct RobustTerm {
  ObjectiveTerm term;
  RobustFigure figure;
};

/// @return those of the terms that are such figures
std::vector<RobustTerm> robust_terms(const DesignSpace& space, const VectorX& x,
                                     const std::vector<ObjectiveTerm>& terms);

}  // namespace balance
