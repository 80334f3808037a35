#pragma once
/// What the efforts of a run add up from, found after the run.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"

namespace balance {

/// Fills the result's torque_inertia … torque_load, in the independent coordinates that EquationTerms chooses.
/// @param result a run of this mechanism that is done
/// @return done, or why the parts cannot be told: the run passes where the independent coordinates do not determine the motion
/// @throws std::invalid_argument if the run has other coordinates than the mechanism
MotionOutcome add_effort_breakdown(const Mechanism& mechanism, RunResult& result);

}  // namespace balance
