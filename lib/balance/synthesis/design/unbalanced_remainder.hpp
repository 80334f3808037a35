#pragma once
/// Elements that the conditions cannot balance, and the actuator efforts that they cause.

#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/synthesis/conditions/unbalanceable_terms.hpp"

#include <string>
#include <vector>

namespace balance::design {

/// The maximum effort of one actuator caused by an element.
struct RemainderEffort {
  std::string trajectory;  ///< empty: at rest, in random poses
  std::string actuator;    ///< name of its coordinate
  std::string unit;        ///< "N m" or "N"
  double magnitude = 0;
};

/// An element that no choice of masses and stiffnesses can balance.
struct UnbalancedRemainder {
  conditions::UnbalanceableElement element;
  std::string text;  ///< "friction in R1 (0.5 N m s/rad viscous)"
  std::vector<RemainderEffort> efforts;
  struct Unknown {
    std::string trajectory, reason;
  };
  std::vector<Unknown> failed_trajectories;  ///< trajectories that cannot be followed
};

/// Computes the efforts of all such elements. At rest: find_peak_static_efforts. Along a trajectory: the change of each
/// actuator's effort when friction, the variation of a load, or the load components that weight cannot balance are
/// removed; at most 1001 samples.
std::vector<UnbalancedRemainder> list_unbalanced_remainders(const Mechanism& mechanism,
                                                            const std::vector<Trajectory>& trajectories,
                                                            const Conditions& conditions,
                                                            const ConditionOptions& options = {});

}  // namespace balance::design
