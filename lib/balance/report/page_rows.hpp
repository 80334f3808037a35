#pragma once
/// Which samples a page shows of runs that have more of them than a screen could tell apart. Private to the page.

#include "balance/result/result.hpp"

#include <vector>

namespace balance {

/// Rows to show, in order, the first and the last among them: all of them if there are no more than `most`. Else evenly spread
/// ones, the largest and the smallest value of every column, and the extremes that stand out most from a straight line between
/// the spread ones.
/// @param runs with samples at the same times
/// @param most at least as many as there are columns, times four
std::vector<Eigen::Index> select_display_rows(const std::vector<const RunResult*>& runs, Eigen::Index most);

/// A run with these samples only.
RunResult extract_rows(const RunResult& result, const std::vector<Eigen::Index>& rows);

}  // namespace balance
