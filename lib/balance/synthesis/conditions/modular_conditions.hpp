#pragma once
/// The modular strategy of P0 section 2.2: a parallel mechanism is split into the chains that carry its platform, each with a
/// share of the platform's and payload's inertia; every chain is balanced as if it were alone; coupled again they are
/// balanced (Propositions 2.2, 2.3). Sufficient, not necessary.

#include "balance/synthesis/conditions/conditions.hpp"

#include <string>
#include <vector>

namespace balance {

/// The chains' conditions together, in the parameters of the whole mechanism. `notes` say how the mechanism was split, how the
/// shares are formed and what inertia is left over with the platform; where that matters, conditions that it be balanced by
/// itself are added, so that the strategy stays sufficient whatever the shares can reproduce.
///
/// Gyroscopic: the efforts have no velocity terms when every chain's are written in the accelerations of its own joints. The
/// complete conditions write them in the accelerations of one spanning tree's joints, which need not be the same.
/// @param goals static, gyroscopic or, for mechanisms without loops, gyroscopic-independent: written in the actuators'
///              accelerations the loops bring the chains' velocity terms back. With or without others the status is mismatch
Conditions derive_modular_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                     const ConditionOptions& options = {});

}  // namespace balance
