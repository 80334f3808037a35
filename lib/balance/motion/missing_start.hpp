#pragma once
/// Why a mechanism is not found in its start pose.

#include "balance/motion/motion.hpp"
#include "balance/motion/plan.hpp"

#include <stdexcept>

namespace balance {

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
