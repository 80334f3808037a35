#pragma once
/// How far the efforts that hold a mechanism at rest are off, over its whole workspace.

#include "balance/analysis/number_opening.hpp"
#include "balance/motion/motion.hpp"
#include "balance/study/design_space.hpp"
#include "balance/study/tolerances.hpp"

#include <string>
#include <vector>

namespace balance {

/// The pose where one actuator's effort at rest is off most; the first one if no number has any influence.
struct StaticDeviation {
  std::string actuator, unit;
  double deviation = 0;  ///< standard deviation to first order [N m or N]; of masses exact
  double effort = 0;     ///< as the spec has it, there [N m or N]
  VectorX pose;          ///< of the independent coordinates [rad]
  VectorX shares;        ///< per number its part of the squared deviation
};

struct StaticTolerance {
  MotionOutcome outcome;                 ///< not done if no pose could be reached and held: why the first one could not
  std::vector<std::string> coordinates;  ///< the independent ones
  std::vector<StaticDeviation> actuators;
  std::vector<IncompatibleParameter> incompatible_parameters;  ///< numbers that are left out of all deviations
  long pose_count = 0, unreachable_count = 0;  ///< of the grid; those that the mechanism cannot take are left out
};

/// Over whole turns of the independent coordinates: a grid, refined about the worst of its poses. A maximum as narrow as the grid's step
/// may be missed.
/// @param steps per turn; chosen by the number of coordinates if 0
/// @throws std::invalid_argument if there are no numbers, no actuators, an independent coordinate is a slide or the poses would be more than 1e5
StaticTolerance analyse_static_tolerance(const DesignSpace& space, const Tolerances& numbers, long steps = 0);

}  // namespace balance
