#pragma once
/// The law by which a path is run through with an angular momentum that does not change. Private to timing.

#include "balance/timing/path_model.hpp"

#include <string>

namespace balance {

struct ConstantMomentumLaw {
  MotionLaw law;
  double momentum = 0;  ///< about the trajectory's point [N m s]
  double min_momentum_per_rate = 0,
         max_momentum_per_rate = 0;  ///< of the angular momentum per rate of the path's parameter [kg m^2]
  std::string refusal;               ///< why there is none; empty: there is
};

/// With h = g(s) s' constant the shaking moment vanishes: s' = h / g, s'' = −h² g' / g³, h = ∫ g ds / T. It exists where g keeps its
/// sign.
/// @param model of a planar mechanism whose first row is the shaking moment
/// @param duration T [s]
ConstantMomentumLaw find_constant_momentum_law(const PathModel& model, double duration);

}  // namespace balance
