#pragma once
/// Figures of a run with derivatives by the free numbers of its spec.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance::design {

/// A figure and its derivative by each free number.
struct ValueWithGradient {
  double value = 0;
  VectorX gradient;
};

/// One quantity: "torque[A1]", "torque" (the worst of them), "mobility".
struct QuantityGradients {
  std::string quantity;
  ValueWithGradient peak, rms, mean, range;
  /// The maximum and minimum in each segment of the run; for the worst of several quantities, those of all of them.
  std::vector<ValueWithGradient> segment_maxima, segment_minima;
};

struct SpecFigureGradients {
  MotionOutcome outcome;                      ///< of the run; the other members are valid only if it is done
  std::vector<QuantityGradients> quantities;  ///< as in the metrics of a run, before round-off is removed
  ValueWithGradient energy;                   ///< [J], zero if powers were not requested
  ValueWithGradient duration;                 ///< [s]
};

/// Applies the chain rule: the spec's expressions are evaluated with dual numbers, dual_width variables at a time,
/// which gives a mechanism and a trajectory with derivatives. Their run is differentiated by the implicit function
/// theorem (mechanics/derivatives/run_gradient.hpp).
/// @param x values of space.start.free_numbers [SI] @param trajectory name of a trajectory in the spec
/// @param quantities such as "torque[A1]", "shaking_moment", "joint_force[B][x]"; those computed along with them are
/// included. Empty: all that a run's metrics have
/// @throws std::invalid_argument if x has the wrong length, if the trajectory is unknown or its law is the result of a
/// search, or if a motion is invalid
SpecFigureGradients compute_figure_gradients(const DesignSpace& space, const VectorX& x, const std::string& trajectory,
                                             const std::vector<std::string>& quantities = {});

/// The quantity of this name; nullptr if there is none.
const QuantityGradients* find_quantity(const SpecFigureGradients& slopes, const std::string& quantity);

}  // namespace balance::design
