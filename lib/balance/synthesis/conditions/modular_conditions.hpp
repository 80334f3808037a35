#pragma once
/// The modular strategy of P0 section 2.2: a parallel mechanism is split into the chains that carry its platform, each
/// with a share of the platform's and payload's inertia. Every chain is balanced as if it were alone; coupled again,
/// the chains are balanced (Propositions 2.2, 2.3). Sufficient, not necessary.

#include "balance/synthesis/conditions/conditions.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// The conditions of all chains, in the parameters of the whole mechanism. `notes` describe how the mechanism was
/// split, how the shares are formed and which inertia remains at the platform. Where that inertia matters, conditions
/// that balance it by itself are added, so that the strategy stays sufficient even if the shares cannot reproduce
/// everything.
///
/// Gyroscopic: the efforts have no velocity terms if those of every chain are expressed in the accelerations of its own
/// joints. The complete conditions express them in the accelerations of the joints of one spanning tree, which need not
/// be the same.
/// @param goals static, gyroscopic or, for mechanisms without loops, gyroscopic-independent: expressed in the
/// actuators' accelerations, loops bring the chains' velocity terms back. With any other goal the status is mismatch
Conditions derive_modular_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                     const ConditionOptions& options = {});

}  // namespace balance::conditions
