#pragma once
/// Peaks, averages and energy of a run.

#include "balance/study/result.hpp"

#include <vector>

namespace balance {

/// Both sides of a jump of the acceleration: row 2k of `sides` is just before, row 2k + 1 just after jump k.
struct Jumps {
  Result sides;                   ///< times and all quantities at the jumps
  std::vector<long> next_sample;  ///< per jump: the first sample at or after it
  std::vector<bool> on_sample;    ///< that sample is at the jump itself and holds its after side
};

/// Fills result.metrics and result.energy. Averages are over time, by the trapezoidal rule between samples and jumps.
void add_metrics(Result& result, const Jumps& jumps);

}  // namespace balance
