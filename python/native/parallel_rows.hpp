#pragma once
/// Efforts of many states in several threads, the same as in one.

#include "balance/inverse/inverse_dynamics.hpp"

#include <functional>

namespace balance::python {

/// N states, one a row; the memory is the caller's.
struct EffortRequest {
  Eigen::Map<const Samples> q, dq, ddq;
  VectorX time;  ///< per state; empty: 0 for all
};

/// InverseDynamics::effort_rows, the rows cut into as many parts as there are threads. Mechanisms with loops reach a state from the one
/// before: each part begins anew, and is computed again behind the part before where it began in another assembly mode.
/// @param is_stopped asked now and then; true: the rest is left as it is
/// @throws std::invalid_argument as InverseDynamics
EffortBatch effort_rows(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& question,
                        unsigned threads, const std::function<bool()>& is_stopped);

}  // namespace balance::python
