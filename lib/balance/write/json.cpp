#include "balance/write/json.hpp"

#include "balance/motion/names.hpp"
#include "balance/write/found_law.hpp"
#include "balance/write/json_parts.hpp"
#include "balance/write/payload_changes.hpp"
#include "balance/write/state_text.hpp"

namespace balance {

std::string format_result_json(const RunResult& result, const Provenance& description,
                               const std::vector<std::string>& files) {
  if (!description.pose.empty()) return state_json(result, description, files);
  Json json = {{"mechanism", description.title},       {"balance_version", description.version},
               {"trajectory", description.trajectory}, {"law", description.law},
               {"drive", description.drive},           {"formulation", description.formulation}};
  if (!description.controller.empty()) {
    json["controller"] = description.controller;
    json["controller_type"] = description.controller_type;
  }
  json["outcome"] = outcome_json(result.outcome);
  json["samples"] = result.time.size();
  json["duration"] = result.time.size() == 0 ? 0 : result.time[result.time.size() - 1] - result.time[0];
  if (result.corridor_result) json["found_corridor"] = corridor_result_json(*result.corridor_result);
  if (result.optimised_law) json["found_law"] = optimised_law_json(*result.optimised_law);
  if (!result.payload_events.empty()) json["payload_changes"] = payload_events_json(result);
  json["about"] = vector_json(result.moment_reference, result.axes);
  json["metrics"] = Json::array();
  for (const Metric& metric : result.metrics) json["metrics"].push_back(metric_json(metric));
  json["energy"] = result.energy;
  json["notes"] = result.outcome.notes;
  json["files"] = files;
  return format_json(json);
}

std::string format_error_json(const std::string& kind, const std::string& message) {
  return format_json({{"error", {{"kind", kind}, {"message", message}}}});
}

std::string format_error_json(const std::string& kind, const std::string& message, const std::string& status) {
  return format_json({{"error", {{"kind", kind}, {"message", message}, {"status", status}}}});
}

std::string format_error_json(const std::string& kind, const SpecError& error) {
  const auto text_or_null = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  const auto count_or_null = [](int count) { return count > 0 ? Json(count) : Json(nullptr); };
  Json mistakes = Json::array();
  for (const Diagnostic& one : error.diagnostics())
    mistakes.push_back({{"file", text_or_null(one.place.file)},
                        {"line", count_or_null(one.place.line)},
                        {"column", count_or_null(one.place.column)},
                        {"key", text_or_null(one.place.key)},
                        {"message", one.message},
                        {"expected", text_or_null(one.expected)},
                        {"found", text_or_null(one.found)},
                        {"hint", text_or_null(one.hint)}});
  return format_json({{"error",
                       {{"kind", kind},
                        {"message", error.what()},
                        {"mistakes", std::move(mistakes)},
                        {"more", error.unlisted_count()}}}});
}

std::string format_error_json(const std::string& kind, const MotionOutcome& outcome) {
  return format_json(
      {{"error",
        {{"kind", kind}, {"message", outcome.reason}, {"status", name_of(outcome.status)}, {"time", outcome.time}}}});
}

}  // namespace balance
