#pragma once
/// What no choice of masses can balance: friction, loads that change or that weight cannot make up for, springs without a
/// counterpart.

#include "balance/synthesis/conditions/conditions.hpp"

#include <string>
#include <vector>

namespace balance {

/// One element that stays, and why.
struct UnbalanceableElement {
  ParameterOwner bearer = ParameterOwner::load;  ///< load, friction or spring
  int index = 0;                                 ///< into the mechanism's
  std::string name;                              ///< "push"; of friction the joint coordinate
  std::vector<int> terms;                        ///< columns of the conditions that stay
  std::vector<int> rows;                         ///< rows of the conditions that say so
};

/// Elements whose terms stand in conditions without any inertial parameter that are not met, in the mechanism's order.
/// @param values of all columns
/// @param tolerance of scaled residuals
std::vector<UnbalanceableElement> list_unbalanceable_elements(const Conditions& conditions, const VectorX& values,
                                                              const Mechanism& mechanism, double tolerance);

/// "friction in R1 (0.5 N m s viscous, 0.2 N m dry)", "load push (m = 2 N m)", "changes of load push over time (fy)".
std::string unbalanceable_element_text(const UnbalanceableElement& remainder, const Conditions& conditions,
                                       const VectorX& values, const Mechanism& mechanism);

/// An effort that an actuator has to bring up.
struct PeakEffort {
  int actuator = -1;     ///< coordinate; −1: there is none that holds the mechanism
  double magnitude = 0;  ///< [N m] or [N]; infinite: too large to be computed with
};

/// What stays of an element at rest when the masses and stiffnesses take what the conditions ask of them: per actuator the
/// largest over random configurations. Of open chains without actuators the tree's joints count. Friction has none.
std::vector<PeakEffort> find_peak_static_efforts(const Mechanism& mechanism, const Conditions& conditions,
                                                 const UnbalanceableElement& remainder,
                                                 const ConditionOptions& options = {});

}  // namespace balance
