#pragma once
/// Why a mechanism is not found in its start pose.

#include "balance/motion/motion.hpp"
#include "balance/motion/plan.hpp"

namespace balance {

/// Of a find_pose that found nothing: do the loops close at all, and if not, which joint stays open?
/// @param attempt what it returned
template <class S>
MotionOutcome explain_missing_start(const Mechanism& mechanism, const Tree<S>& tree, const Solution& attempt);

#define BALANCE_DECLARE(S) \
  extern template MotionOutcome explain_missing_start<S>(const Mechanism&, const Tree<S>&, const Solution&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance
