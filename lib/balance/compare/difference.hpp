#pragma once
/// How far the samples of two runs are apart. Private to compare.

#include "balance/compare/comparison.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance {

/// Whether their times can be compared as they are: durations differ by round-off only.
bool have_equal_durations(const RunResult& a, const RunResult& b);

/// [s]; 0 without samples.
double duration_of(const RunResult& result);

/// Of every quantity that both have with as many components. Behind them the worst of each that is several: "torque" of "torque[A1]", …,
/// by the largest of their figures.
std::vector<std::pair<std::string, Difference>> list_differences(const RunResult& base, const RunResult& other);

}  // namespace balance
