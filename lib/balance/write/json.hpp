#pragma once
/// Results and errors as JSON for programs.

#include "balance/base/error.hpp"
#include "balance/motion/motion.hpp"
#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>
#include <vector>

namespace balance {

/// One object: what was run, how it ended, the metrics and the files written; ends with a line feed.
std::string format_result_json(const RunResult& result, const Provenance& description,
                               const std::vector<std::string>& files);

/// {"error": {"kind": …, "message": …}}; what stopped early adds its status, a motion the time too.
std::string format_error_json(const std::string& kind, const std::string& message);
std::string format_error_json(const std::string& kind, const std::string& message, const std::string& status);
std::string format_error_json(const std::string& kind, const MotionOutcome& outcome);
/// Adds "mistakes", each with its file, line, column, key, message, expected, found, hint (null where there is none), and "more",
/// how many mistakes there are besides.
std::string format_error_json(const std::string& kind, const SpecError& error);

}  // namespace balance
