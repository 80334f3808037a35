#pragma once
/// One run as the page shows it. Private to the page: it knows the JSON library.

#include "balance/model/mechanism.hpp"
#include "balance/study/result.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// Outcome, metrics, times, poses of all bodies, and every quantity over time.
/// @throws std::invalid_argument if the run is of another mechanism
Json run_page_json(const Mechanism& mechanism, const Result& result);

}  // namespace balance
