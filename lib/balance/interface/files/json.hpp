#pragma once
/// Results and errors as JSON for programs.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <nlohmann/json.hpp>

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

// Pieces that several JSON documents share.

/// Keeps the order in which keys are written.
using Json = nlohmann::ordered_json;

/// Two spaces deep, ending with a line feed. What is not finite is null.
std::string format_json(const Json& value);

Json vector_json(const Vector3& vector, int axes);
Json numbers_json(const VectorX& numbers);
Json metric_json(const Metric& metric);
Json outcome_json(const MotionOutcome& outcome);

}  // namespace balance
