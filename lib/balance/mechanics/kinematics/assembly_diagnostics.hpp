#pragma once
/// Explains why a mechanism cannot be assembled in its start pose.

#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <stdexcept>
#include <string>

namespace balance::kinematics {

// Collinear links, which characterise dead points and outstretched arms.

/// "a and b are in line at B"; empty if no links are collinear, or too many to be informative.
/// @param state poses
template <class S>
std::string describe_collinear_links(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state);

extern template std::string describe_collinear_links<Planar>(const Mechanism&, const Tree<Planar>&,
                                                             const TreeState<Planar>&);
extern template std::string describe_collinear_links<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                              const TreeState<Spatial>&);

/// Thrown if no state of the mechanism can be computed: its loops cannot be closed, or no coordinates determine its
/// motion.
class UnsolvableMechanism : public std::invalid_argument {
 public:
  explicit UnsolvableMechanism(const MotionOutcome& failure)
      : std::invalid_argument(failure.reason), outcome(failure) {}
  MotionOutcome outcome;
};

/// Explains a failed solve_pose(): which joint stays open if the loops cannot be closed at all; otherwise which values
/// of the pose are missed, and the nearest ones that can be reached.
/// @param attempt what it returned
/// @param pose what it looked for
template <class S>
MotionOutcome explain_assembly_failure(const Mechanism& mechanism, const Tree<S>& tree, const AssemblySolution& attempt,
                                       const trajectory::PoseTarget& pose);

/// Which values of a pose are missed, by how much, and the nearest ones: "it asks for the tool at (3, 4) m (nearest is
/// (1.2, 1.6) m), 3 m out of reach; there a and b are in line at B"; then, of several legs, those that miss it by
/// themselves. Empty if the pose can be reached, or the nearest configuration is not known.
std::string describe_unreachable_pose(const Mechanism& mechanism, const trajectory::PoseTarget& pose);

#define BALANCE_DECLARE(S)                                                                                             \
  extern template MotionOutcome explain_assembly_failure<S>(const Mechanism&, const Tree<S>&, const AssemblySolution&, \
                                                            const trajectory::PoseTarget&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance::kinematics
