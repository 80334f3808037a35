#pragma once
/// Results as text for people.

#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>

namespace balance {

/// One line on what was run, then a table of the metrics with six significant digits, ending with a newline.
std::string format_result_summary(const RunResult& result, const Provenance& description);

}  // namespace balance
