#pragma once
/// Results as text for people.

#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>

namespace balance::files {

/// What was run, then a table of the metrics with six significant digits, ending with a newline. Figures of a single
/// joint, actuator or constraint that are zero throughout, other than efforts and powers, are left out unless verbose.
std::string format_result_summary(const RunResult& result, const Provenance& description,
                                  const TextOptions& options = {});

}  // namespace balance::files
