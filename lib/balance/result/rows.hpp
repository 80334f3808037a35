#pragma once
/// The rows of a Result of a run under control. For what makes one.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"

namespace balance {

enum class Wanted { known, unknown };

/// Room for as many rows in what only a run under control has; names and everything else must be there.
/// @param wanted unknown: none for what needs a desired motion
void size_control_rows(const Mechanism& mechanism, long rows, Wanted wanted, Result& result);

/// Forgets all samples but the first `rows`.
void cut_rows(long rows, Result& result);

}  // namespace balance
