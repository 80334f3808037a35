#pragma once
/// Figures of a run with their derivatives by the free numbers of its spec.

#include "balance/motion/motion.hpp"
#include "balance/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance {

/// A figure and one derivative per free number.
struct Slope {
  double value = 0;
  VectorX by_number;
};

/// Of one quantity: "torque[A1]", "torque" (the worst of them), "mobility".
struct QuantitySlopes {
  std::string quantity;
  Slope peak, rms, mean, range;
};

struct FigureSlopes {
  MotionOutcome outcome;                   ///< of the run; what follows is there if it is done
  std::vector<QuantitySlopes> quantities;  ///< as a run's metrics, before round-off is dropped
  Slope energy;                            ///< [J]
};

/// By the chain rule: the spec's expressions over numbers with derivatives make a mechanism with derivatives, and the run of that is
/// differentiated by the implicit function theorem (gradients/motion_gradient.hpp), dual_width numbers at a time. Numbers that the
/// trajectory itself depends on are moved by a ten-thousandth of their range to both sides as far as their bounds allow, instead: their
/// derivatives are differences, good to 1e-7 of the figure inside the bounds, and NaN where one of these runs fails.
/// @param x values of space.start.free_numbers [SI] @param trajectory a name of the spec's
/// @throws std::invalid_argument for a vector of another length, a trajectory that the spec has not, one whose law is searched for, and
///         where a motion cannot be stated
FigureSlopes figure_slopes(const DesignSpace& space, const VectorX& x, const std::string& trajectory);

/// The quantity of that name; null if there is none.
const QuantitySlopes* find_quantity(const FigureSlopes& slopes, const std::string& quantity);

}  // namespace balance
