#pragma once
/// One run as the page shows it. Private to the page: it knows the JSON library.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"
#include "balance/write/json_parts.hpp"

#include <vector>

namespace balance {

/// Outcome, metrics, times, poses of all bodies, and every quantity over time, what is round-off as 0.
/// @param rows samples to show
/// @param deviation standard deviations of the run's arrays, with as many samples; null: not known
/// @throws std::invalid_argument if the run is of another mechanism
Json run_data_json(const Mechanism& mechanism, const RunResult& result, const std::vector<Eigen::Index>& rows,
                   const RunResult* deviation);

}  // namespace balance
