#pragma once
/// Motions that a design must be able to perform.

#include "balance/motion/study/design_space.hpp"

#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace balance::design {

/// The trajectories that do not depend on masses and that the initial mechanism can follow. If it cannot be assembled,
/// all that do not depend on masses.
class RequiredMotions {
 public:
  explicit RequiredMotions(const Study& start);

  /// The mechanism of an instance, assembled in the mode that is followed or else as near as possible to the initial
  /// mechanism.
  Mechanism assembled_mechanism(study::DesignInstance instance, bool is_mode_followed) const;
  /// All numbers that decide about feasibility: instances with the same numbers are equally feasible.
  VectorX numbers(const study::DesignInstance& instance) const;
  /// Why the first infeasible motion cannot be performed; empty if all are feasible.
  std::string infeasibility_reason(const study::DesignInstance& instance) const;

 private:
  std::string simulate_motions(const study::DesignInstance& instance) const;

  std::vector<CoordinateValue> coordinates_;
  std::vector<std::string> motions_;
  /// Numbers and answers of the last instances: most designs that a search compares differ only in masses.
  mutable std::deque<std::pair<VectorX, std::string>> known_reasons_;
};

// Trial designs all of whose expressions have values.

/// The first issue that validate reports, as a sentence; empty if there is none.
std::string find_validation_issue(const Mechanism& mechanism);

/// The mechanism and its trajectories for values of the free numbers.
/// @throws SpecError if an expression of the mechanism has no value
study::DesignInstance instantiate_checked(const DesignSpace& space, const VectorX& x);

/// The mechanism without masses, inertias, their places, and the springs' stiffness.
template <class T>
MechanismOf<T> without_masses(MechanismOf<T> mechanism) {
  for (auto& body : mechanism.bodies) body.mass = 0, body.com.setZero(), body.inertia.setZero();
  for (auto& extra : mechanism.attachments) extra.mass = 0, extra.position.setZero(), extra.inertia.setZero();
  for (auto& disc : mechanism.discs) disc.mass = 0, disc.inertia.setZero();
  for (auto& spring : mechanism.springs) spring.stiffness = spring.preload = 0;
  return mechanism;
}

/// All numbers of a mechanism and a trajectory that its motion along it, and forces per unit of the parameters, depend on:
/// all but masses, inertias, the attachments' places and the springs' stiffness. Trajectories that depend on masses
/// (is_mass_dependent) are not determined by them.
VectorX collect_motion_numbers(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::design
