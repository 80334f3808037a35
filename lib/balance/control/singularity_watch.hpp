#pragma once
/// Whether the actuators still determine the motion: notices when the mechanism passes a configuration in which they do not.

#include "balance/base/tall_matrix.hpp"
#include "balance/control/forward_dynamics.hpp"

namespace balance {

class ActuationMonitor {
 public:
  /// @param mechanism must outlive the watch
  explicit ActuationMonitor(const Mechanism& mechanism);

  /// Looks at a state, in the order of time and at moments between which little changes.
  /// @param position, velocity per mechanism coordinate
  /// @return done; actuation_singularity if loops and actuated coordinates together do not determine the motion, or did not on the
  ///         straight way from their matrix at the last look. Always done where there are fewer actuators than freedoms.
  MotionOutcome check(double time, const VectorX& position, const VectorX& velocity);

 private:
  MatrixX matrix();

  const Mechanism& mechanism_;
  ForwardDynamics dynamics_;
  RankMonitor watched_;
  bool has_previous_ = false;
};

}  // namespace balance
