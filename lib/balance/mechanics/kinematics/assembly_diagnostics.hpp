#pragma once
/// Why a mechanism is not found in its start pose.

#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <stdexcept>
#include <string>

namespace balance {

// Links that lie in line with each other: what dead points and outstretched arms are recognised by.

/// "a and b are in line at B"; empty if no two links are, or so many that it says nothing.
/// @param state poses
template <class S>
std::string describe_collinear_links(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state);

extern template std::string describe_collinear_links<Planar>(const Mechanism&, const Tree<Planar>&,
                                                             const TreeState<Planar>&);
extern template std::string describe_collinear_links<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                              const TreeState<Spatial>&);

/// No question about states of the mechanism has an answer: its loops cannot be closed, or no coordinates determine its motion.
class UnsolvableMechanism : public std::invalid_argument {
 public:
  explicit UnsolvableMechanism(const MotionOutcome& found) : std::invalid_argument(found.reason), outcome(found) {}
  MotionOutcome outcome;
};

/// Of a find_pose that found nothing: do the loops close at all, and if not, which joint stays open? What of the pose is missed, and what
/// is the nearest that can be reached?
/// @param attempt what it returned
/// @param pose what it looked for
template <class S>
MotionOutcome explain_assembly_failure(const Mechanism& mechanism, const Tree<S>& tree, const AssemblySolution& attempt,
                                       const PoseTarget& pose);

#define BALANCE_DECLARE(S)                                                                                             \
  extern template MotionOutcome explain_assembly_failure<S>(const Mechanism&, const Tree<S>&, const AssemblySolution&, \
                                                            const PoseTarget&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance
