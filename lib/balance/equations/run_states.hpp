#pragma once
/// A run as states in the independent coordinates of its mechanism. Private to equations and the rooms that open it up.

#include "balance/equations/equation_terms.hpp"
#include "balance/result/result.hpp"

namespace balance {

/// One state a row.
struct StateTable {
  Samples q, dq, ddq;  ///< N×d
};

/// @throws std::invalid_argument if the run has other coordinates than the mechanism
StateTable extract_independent_states(const EquationTerms& terms, const RunResult& result);

/// Takes the assembly mode of a sample of a run.
MotionOutcome assemble_at_row(EquationTerms& terms, const RunResult& result, Eigen::Index row = 0);

}  // namespace balance
