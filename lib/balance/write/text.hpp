#pragma once
/// Results as text for people.

#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>

namespace balance {

/// One line on what was run, then a table of the metrics, six significant digits, ending with a line feed.
std::string format_result_summary(const RunResult& result, const Provenance& description);

}  // namespace balance
