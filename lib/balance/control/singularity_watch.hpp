#pragma once
/// Whether the actuators still determine the motion: notices when the mechanism passes a configuration in which they do not.

#include "balance/control/forward_dynamics.hpp"

namespace balance {

class SingularityWatch {
 public:
  /// @param mechanism must outlive the watch
  explicit SingularityWatch(const Mechanism& mechanism);

  /// Looks at a state, in the order of time.
  /// @param position, velocity per mechanism coordinate
  /// @return done; actuation_singularity if the determinant of loops and actuated coordinates together has changed its sign since
  ///         the last look, or is zero. Always done where loops are redundant or actuators and freedoms differ in number.
  MotionOutcome look(double time, const VectorX& position, const VectorX& velocity);

 private:
  ForwardDynamics dynamics_;
  int sign_ = 0;
};

}  // namespace balance
