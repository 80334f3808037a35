#pragma once
/// Terms that no choice of masses can balance: friction, loads that change over time or that weight cannot balance,
/// springs without a counterpart.

#include "balance/synthesis/conditions/conditions.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// One element that remains unbalanced, and why.
struct UnbalanceableElement {
  dynamics::ParameterOwner bearer = dynamics::ParameterOwner::load;  ///< load, friction, spring or force element
  int index = 0;                                                     ///< in the mechanism's list
  std::string name;                                                  ///< "push"; for friction, the joint coordinate
  std::vector<int> terms;                                            ///< columns of the conditions that remain
  std::vector<int> rows;                                             ///< rows of the conditions that show this
};

/// Elements whose terms occur in violated conditions without any inertial parameter, in the mechanism's order.
/// @param values of all columns
/// @param tolerance of scaled residuals
std::vector<UnbalanceableElement> list_unbalanceable_elements(const Conditions& conditions, const VectorX& values,
                                                              const Mechanism& mechanism, double tolerance);

/// Whether it is a damper between points. @param terms those of its conditions
bool is_damper(const UnbalanceableElement& element, const std::vector<dynamics::Parameter>& terms);

/// "friction in R1 (0.5 N m s viscous, 0.2 N m dry)", "load push (m = 2 N m)", "changes of load push over time (fy)".
std::string unbalanceable_element_text(const UnbalanceableElement& remainder, const Conditions& conditions,
                                       const VectorX& values);

/// The maximum effort required of an actuator.
struct PeakEffort {
  int actuator = -1;     ///< coordinate; −1: no actuator holds the mechanism
  double magnitude = 0;  ///< [N m] or [N]; infinite: overflow
};

/// What remains of an element's static efforts if masses and stiffnesses balance as much of it as the conditions
/// require: per actuator, the maximum over random configurations. In open chains without actuators, all joints count as
/// actuated. Friction has no static efforts.
std::vector<PeakEffort> find_peak_static_efforts(const Mechanism& mechanism, const Conditions& conditions,
                                                 const UnbalanceableElement& remainder,
                                                 const ConditionOptions& options = {});

}  // namespace balance::conditions
