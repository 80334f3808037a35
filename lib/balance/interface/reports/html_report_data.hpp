#pragma once
/// Which samples a page shows of runs that have more of them than a screen could tell apart.

#include "balance/foundation/base/types.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace balance {

// Samples as text: base64 of little-endian floating-point numbers.

/// RFC 4648 with padding.
std::string base64(std::string_view bytes);

/// Four bytes a number, seven digits: what a picture needs.
std::string base64_floats(const Samples& by_row);
/// The same column after column.
std::string base64_float_columns(const Samples& samples);
/// Eight bytes a number.
std::string base64_doubles(const VectorX& numbers);

// The mechanism as the page draws it.

/// Bodies, joints, attachments, discs, springs and tool with their places; indices as in the mechanism.
Json mechanism_json(const Mechanism& mechanism);

/// Rows to show, in order, the first and the last among them: all of them if there are no more than `most`. Else evenly spread
/// ones, the largest and the smallest value of every column, and the extremes that stand out most from a straight line between
/// the spread ones.
/// @param runs with samples at the same times
/// @param most at least as many as there are columns, times four
std::vector<Eigen::Index> select_display_rows(const std::vector<const RunResult*>& runs, Eigen::Index most);

/// A run with these samples only.
RunResult extract_rows(const RunResult& result, const std::vector<Eigen::Index>& rows);

// One run as the page shows it.

/// Outcome, metrics, times, poses of all bodies, and every quantity over time, what is round-off as 0.
/// @param rows samples to show
/// @param deviation standard deviations of the run's arrays, with as many samples; null: not known
/// @throws std::invalid_argument if the run is of another mechanism
Json run_data_json(const Mechanism& mechanism, const RunResult& result, const std::vector<Eigen::Index>& rows,
                   const RunResult* deviation);

}  // namespace balance
