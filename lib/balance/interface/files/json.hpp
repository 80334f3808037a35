#pragma once
/// Results and errors as JSON for programs.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace balance::files {

/// One object: what was run, how it ended, the metrics and the files written; ends with a newline.
std::string format_result_json(const RunResult& result, const Provenance& description,
                               const std::vector<std::string>& files);

/// {"error": {"kind": …, "message": …}}; a premature end adds its status, that of a motion also the time.
std::string format_error_json(const std::string& kind, const std::string& message);
std::string format_error_json(const std::string& kind, const std::string& message, const std::string& status);
std::string format_error_json(const std::string& kind, const MotionOutcome& outcome);
/// Adds "mistakes", each with its file, line, column, key, message, expected, found, hint (null if there is none), and
/// "more", the number of further mistakes.
std::string format_error_json(const std::string& kind, const SpecError& error);

// Pieces shared by several JSON documents.

/// Preserves the order of the keys.
using Json = nlohmann::ordered_json;

/// Indented by two spaces, ending with a newline. Non-finite numbers become null.
std::string format_json(const Json& value);

/// The function's value for each element of a range.
template <class Range, class Function>
Json list_json(const Range& range, const Function& function) {
  Json list = Json::array();
  for (const auto& element : range) list.push_back(function(element));
  return list;
}

inline Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

/// {"name": value, …}: as many as there are names and values.
Json named_numbers_json(const std::vector<std::string>& names, const VectorX& values);

Json vector_json(const Vector3& vector, int axes);
Json numbers_json(const VectorX& numbers);
Json metrics_json(const std::vector<Metric>& metrics);
Json outcome_json(const MotionOutcome& outcome);

}  // namespace balance::files

namespace balance {

using files::Json;

}  // namespace balance
