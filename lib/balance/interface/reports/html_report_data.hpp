#pragma once
/// Data of the HTML page: samples as text, the mechanism, and runs, thinned to what a screen can resolve.

#include "balance/foundation/base/types.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace balance::reports {

/// What the program's commands print as JSON; null where it was not asked for.
struct ReportedAnswers {
  Json check = Json::object();
  Json conditions, design;
  Json front;                       ///< a trade-off whose middle is `design`
  Json vibrations = Json::array();  ///< of trajectories with free coordinates
};

// Samples as text: base64 of little-endian floating-point numbers.

/// RFC 4648 with padding.
std::string base64(std::string_view bytes);

/// Four bytes per number, seven digits: enough for a picture.
std::string base64_floats(const Samples& by_row);
/// The same, column by column.
std::string base64_float_columns(const Samples& samples);
/// Eight bytes per number.
std::string base64_doubles(const VectorX& numbers);

// The mechanism as the page draws it.

/// Bodies, joints, attachments, discs, springs and tool with their positions; indices as in the mechanism.
Json mechanism_json(const Mechanism& mechanism);

/// Rows to show, in order, including the first and the last: all of them if there are at most `max_rows`. Otherwise
/// evenly spaced rows, the minimum and maximum of every column, and the extremes that deviate most from straight
/// lines between the evenly spaced rows.
/// @param runs with samples at the same times
/// @param max_rows at least four times the number of columns
std::vector<Eigen::Index> select_display_rows(const std::vector<const RunResult*>& runs, Eigen::Index max_rows);

/// A run with only these samples.
RunResult extract_rows(const RunResult& result, const std::vector<Eigen::Index>& rows);

// One run as the page shows it.

/// Outcome, metrics, times, poses of all bodies, and every quantity over time with round-off set to 0.
/// @param rows samples to show
/// @param deviation standard deviations of the run's arrays, with the same number of samples; null: unknown
/// @throws std::invalid_argument if the run is of another mechanism
Json run_data_json(const Mechanism& mechanism, const RunResult& result, const std::vector<Eigen::Index>& rows,
                   const RunResult* deviation);

}  // namespace balance::reports
