#pragma once
/// The rows of a Result of a run under control. Private to study.

#include "balance/model/mechanism.hpp"
#include "balance/study/result.hpp"

namespace balance {

/// Room for as many rows in what only a run under control has; names and everything else must be there.
void size_control_rows(const Mechanism& mechanism, long rows, Result& result);

/// Forgets all samples but the first `rows`.
void cut_rows(long rows, Result& result);

}  // namespace balance
