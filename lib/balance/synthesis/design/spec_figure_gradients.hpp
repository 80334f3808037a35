#pragma once
/// Figures of a run with their derivatives by the free numbers of its spec.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance {

/// A figure and one derivative per free number.
struct ValueWithGradient {
  double value = 0;
  VectorX gradient;
};

/// Of one quantity: "torque[A1]", "torque" (the worst of them), "mobility".
struct QuantityGradients {
  std::string quantity;
  ValueWithGradient peak, rms, mean, range;
  /// Stretch by stretch of the run, of the worst ones all of them: the largest and the least value.
  std::vector<ValueWithGradient> segment_maxima, segment_minima;
};

struct SpecFigureGradients {
  MotionOutcome outcome;                      ///< of the run; what follows is there if it is done
  std::vector<QuantityGradients> quantities;  ///< as a run's metrics, before round-off is dropped
  ValueWithGradient energy;                   ///< [J], zero where powers were not asked for
  ValueWithGradient duration;                 ///< [s]
};

/// By the chain rule: the spec's expressions over numbers with derivatives make a mechanism and a trajectory with derivatives, and the
/// run of these is differentiated by the implicit function theorem (mechanics/derivatives/run_gradient.hpp), dual_width numbers at a time.
/// @param x values of space.start.free_numbers [SI] @param trajectory a name of the spec's
/// @param quantities as "torque[A1]", "shaking_moment"; those that are computed with them come along. Empty: all there are
/// @throws std::invalid_argument for a vector of another length, a trajectory that the spec has not, one whose law is searched for, and
///         where a motion cannot be stated
SpecFigureGradients compute_figure_gradients(const DesignSpace& space, const VectorX& x, const std::string& trajectory,
                                             const std::vector<std::string>& quantities = {});

/// The quantity of that name; null if there is none.
const QuantityGradients* find_quantity(const SpecFigureGradients& slopes, const std::string& quantity);

}  // namespace balance
