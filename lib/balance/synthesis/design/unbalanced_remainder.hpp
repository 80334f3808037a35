#pragma once
/// What conditions cannot balance, with the efforts that it leaves to the actuators.

#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/synthesis/conditions/unbalanceable_terms.hpp"

#include <string>
#include <vector>

namespace balance {

/// The largest effort of one actuator that an element leaves.
struct RemainderEffort {
  std::string trajectory;  ///< empty: at rest, in random poses
  std::string actuator;    ///< its coordinate's name
  std::string unit;        ///< "N m" or "N"
  double magnitude = 0;
};

/// One element that no choice of masses and stiffnesses can balance.
struct UnbalancedRemainder {
  UnbalanceableElement element;
  std::string text;  ///< "friction in R1 (0.5 N m s/rad viscous)"
  std::vector<RemainderEffort> efforts;
  struct Unknown {
    std::string trajectory, reason;
  };
  std::vector<Unknown> failed_trajectories;  ///< trajectories that cannot be followed
};

/// Loads at rest: find_peak_static_efforts. Along a trajectory: by how much every actuator's effort changes when
/// friction, or what a load changes by, or the components of it that weight cannot help, are taken away; at most 1001 samples.
std::vector<UnbalancedRemainder> list_unbalanced_remainders(const Mechanism& mechanism,
                                                            const std::vector<Trajectory>& trajectories,
                                                            const Conditions& conditions,
                                                            const ConditionOptions& options = {});

}  // namespace balance
