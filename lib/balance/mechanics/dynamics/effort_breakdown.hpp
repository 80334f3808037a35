#pragma once
/// The parts of which the efforts of a run are the sum, computed after the run.

#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

namespace balance::dynamics {

/// Fills the result's torque_inertia … torque_load, in the independent coordinates that EquationTerms chooses.
/// @param result a run of this mechanism whose outcome is done
/// @return done, or why the parts cannot be determined: the run passes a configuration in which the independent
///        coordinates do not determine the motion
/// @throws std::invalid_argument if the run has other coordinates than the mechanism
MotionOutcome add_effort_breakdown(const Mechanism& mechanism, RunResult& result);

// A run as states in the independent coordinates of its mechanism.

/// One state per row.
struct StateTable {
  Samples q, dq, ddq;  ///< N×d
};

/// @throws std::invalid_argument if the run has other coordinates than the mechanism
StateTable extract_independent_states(const EquationTerms& terms, const RunResult& result);

/// Assembles the mechanism in the mode of one sample of a run.
MotionOutcome assemble_at_row(EquationTerms& terms, const RunResult& result, Eigen::Index row = 0);

}  // namespace balance::dynamics
