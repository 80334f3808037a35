#include "balance/write/json.hpp"

#include "balance/write/json_parts.hpp"
#include "balance/write/names.hpp"
#include "balance/write/verify_text.hpp"

namespace balance {
namespace {

Json loop_json(const Loop& loop) {
  return {{"cut_joint", loop.cut_joint}, {"bodies", loop.bodies}, {"closure_equations", loop.constraints}};
}

Json coordinates_json(const std::vector<double>& values, const Mechanism& mechanism) {
  Json json = Json::object();
  if (values.size() != mechanism.coordinates.size()) return json;
  for (std::size_t i = 0; i < values.size(); ++i) json[mechanism.coordinates[i].name] = values[i];
  return json;
}

Json mode_json(const AssemblyMode& mode, const Mechanism& mechanism) {
  return {{"coordinates", coordinates_json(mode.coordinates, mechanism)},
          {"assembly", mode.assembly_line},
          {"selected", mode.selected}};
}

}  // namespace

std::string result_json(const Result& result, const FileDescription& description,
                        const std::vector<std::string>& files) {
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
  json["about"] = vector_json(result.about, result.axes);
  json["metrics"] = Json::array();
  for (const Metric& metric : result.metrics) json["metrics"].push_back(metric_json(metric));
  json["energy"] = result.energy;
  json["notes"] = result.outcome.notes;
  json["files"] = files;
  return dump(json);
}

std::string check_json(const CheckReport& report, const Mechanism& mechanism, const std::vector<std::string>& warnings,
                       const VerifyReport* verified) {
  const bool planar = mechanism.space == SpaceKind::planar;
  Json json = {{"mechanism", mechanism.name}, {"space", planar ? "planar" : "spatial"}};
  json["outcome"] = outcome_json(report.outcome);
  json["bodies"] = report.bodies;
  json["joints"] = report.joints;
  json["tree_joints"] = report.tree_joints;
  json["loops"] = Json::array();
  for (const Loop& loop : report.loops) json["loops"].push_back(loop_json(loop));
  json["tree_coordinates"] = report.tree_coordinates;
  json["closure_equations"] = report.closure_equations;
  json["closure_rank"] = report.closure_rank;
  json["degrees_of_freedom"] = report.degrees_of_freedom;
  json["degrees_of_freedom_by_counting"] = report.degrees_of_freedom_by_counting;
  json["redundant"] = report.redundant;
  json["idle"] = report.idle;
  json["total_mass"] = report.total_mass;
  json["com"] = vector_json(report.com, planar ? 2 : 3);
  json["start"] = coordinates_json(report.start, mechanism);
  json["modes"] = Json::array();
  for (const AssemblyMode& mode : report.modes) json["modes"].push_back(mode_json(mode, mechanism));
  json["notes"] = report.notes;
  json["warnings"] = warnings;
  if (verified != nullptr) json["verification"] = verify_json(*verified);
  return dump(json);
}

std::string error_json(const std::string& kind, const std::string& message) {
  return dump({{"error", {{"kind", kind}, {"message", message}}}});
}

std::string error_json(const std::string& kind, const std::string& message, const std::string& status) {
  return dump({{"error", {{"kind", kind}, {"message", message}, {"status", status}}}});
}

std::string error_json(const std::string& kind, const SpecError& error) {
  const auto text_or_null = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  const auto count_or_null = [](int count) { return count > 0 ? Json(count) : Json(nullptr); };
  Json mistakes = Json::array();
  for (const Mistake& one : error.mistakes())
    mistakes.push_back({{"file", text_or_null(one.place.file)},
                        {"line", count_or_null(one.place.line)},
                        {"column", count_or_null(one.place.column)},
                        {"key", text_or_null(one.place.key)},
                        {"message", one.message},
                        {"expected", text_or_null(one.expected)},
                        {"found", text_or_null(one.found)},
                        {"hint", text_or_null(one.hint)}});
  return dump(
      {{"error",
        {{"kind", kind}, {"message", error.what()}, {"mistakes", std::move(mistakes)}, {"more", error.more()}}}});
}

std::string error_json(const std::string& kind, const MotionOutcome& outcome) {
  return dump(
      {{"error",
        {{"kind", kind}, {"message", outcome.reason}, {"status", name_of(outcome.status)}, {"time", outcome.time}}}});
}

}  // namespace balance
