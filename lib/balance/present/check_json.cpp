#include "balance/present/check_json.hpp"

#include "balance/present/verify_text.hpp"
#include "balance/write/json_parts.hpp"

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
          {"selected", mode.is_selected}};
}

}  // namespace

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
  json["rate_equations"] = report.rate_equations;
  json["rate_rank"] = report.rate_rank;
  json["configuration_freedoms"] = report.configuration_freedoms;
  json["degrees_of_freedom"] = report.degrees_of_freedom;
  json["degrees_of_freedom_by_counting"] = report.gruebler_degrees_of_freedom;
  json["redundant"] = report.redundant;
  json["passive_freedoms"] = report.passive_freedoms;
  json["size"] = characteristic_length(mechanism);
  json["total_mass"] = report.total_mass;
  json["com"] = vector_json(report.com, planar ? 2 : 3);
  json["start"] = coordinates_json(report.start, mechanism);
  json["modes"] = Json::array();
  for (const AssemblyMode& mode : report.modes) json["modes"].push_back(mode_json(mode, mechanism));
  json["notes"] = report.notes;
  json["warnings"] = warnings;
  if (verified != nullptr) json["verification"] = verify_json(*verified);
  return format_json(json);
}

}  // namespace balance
