#include "balance/interface/reports/check_sections.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

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
                       const VerifyReport* verification) {
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
  if (verification != nullptr) json["verification"] = verify_json(*verification);
  return format_json(json);
}

namespace {

constexpr std::size_t label_width = 20;
constexpr std::size_t line_width = 100;

/// A long label widens its own line; a space always separates it from the value.
std::string format_property(const std::string& label, const std::string& value) {
  return fmt::format("{:<{}} {}\n", label, label_width - 1, value);
}

/// Items separated by commas, on as many lines as needed.
std::string wrap_list(const std::string& label, const std::vector<std::string>& items) {
  std::string text, current;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string item = items[i] + (i + 1 < items.size() ? "," : "");
    if (!current.empty() && label_width + current.size() + 1 + item.size() > line_width) {
      text += format_property(text.empty() ? label : "", current);
      current.clear();
    }
    current += (current.empty() ? "" : " ") + item;
  }
  return text + format_property(text.empty() ? label : "", current);
}

std::string list_or_none(const std::string& label, const std::vector<std::string>& items) {
  if (items.empty()) return format_property(label, "none");
  std::string text;
  for (const std::string& item : items) text += format_property(&item == &items.front() ? label : "", item);
  return text;
}

std::string position_text(const Vector3& position, SpaceKind space) {
  return space == SpaceKind::planar
             ? fmt::format("({:.6g}, {:.6g}) m", position.x(), position.y())
             : fmt::format("({:.6g}, {:.6g}, {:.6g}) m", position.x(), position.y(), position.z());
}

std::string loops_text(const CheckReport& report) {
  if (report.loops.empty()) return format_property("loops", "none");
  std::string text = format_property("loops", std::to_string(report.loops.size()));
  for (const Loop& loop : report.loops) {
    text += format_property(
        "  cut at " + loop.cut_joint,
        fmt::format("{}; {}", fmt::join(loop.bodies, " - "), count_noun(loop.constraints, "equation", "equations")));
  }
  return text;
}

std::string freedom_text(const CheckReport& report) {
  const std::string by_rank =
      report.closure_equations == 0
          ? count_noun(report.tree_coordinates, "coordinate", "coordinates")
          : fmt::format("{} - {} independent of {}", count_noun(report.tree_coordinates, "coordinate", "coordinates"),
                        report.closure_rank,
                        count_noun(report.closure_equations, "closure equation", "closure equations"));
  if (report.rate_equations == 0)
    return format_property("degrees of freedom", fmt::format("{} ({}); by counting {}", report.degrees_of_freedom,
                                                             by_rank, report.gruebler_degrees_of_freedom));
  return format_property("degrees of freedom",
                         fmt::format("{} of the configuration ({}); by counting {}", report.configuration_freedoms,
                                     by_rank, report.gruebler_degrees_of_freedom)) +
         format_property("",
                         fmt::format("{} of the velocity ({} less, by {})", report.degrees_of_freedom, report.rate_rank,
                                     count_noun(report.rate_equations, "equation of rates", "equations of rates")));
}

std::string start_text(const CheckReport& report, const Mechanism& mechanism) {
  if (report.start.size() != mechanism.coordinates.size() || report.start.empty()) return "";
  std::vector<std::string> values;
  for (std::size_t i = 0; i < report.start.size(); ++i) {
    const Coordinate& coordinate = mechanism.coordinates[i];
    const char* unit = coordinate.kind == CoordinateKind::angle ? "rad" : "m";
    values.push_back(fmt::format("{} = {:.6g} {}", coordinate.name, report.start[i], unit));
  }
  return wrap_list("start pose", values);
}

std::string modes_text(const CheckReport& report) {
  if (report.modes.empty()) return "";
  std::string text = format_property("assembly modes", fmt::format("{} found at the start pose", report.modes.size()));
  for (const AssemblyMode& mode : report.modes) {
    if (mode.assembly_line.empty()) continue;  // nothing to choose
    text += fmt::format("  {} {}{}\n", mode.is_selected ? "*" : " ", mode.assembly_line,
                        mode.is_selected ? "   # selected by the spec" : "");
  }
  return text;
}

}  // namespace

std::string check_text(const CheckReport& report, const Mechanism& mechanism) {
  std::string text =
      fmt::format("{} ({})\n\n", mechanism.name, mechanism.space == SpaceKind::planar ? "planar" : "spatial");
  text += format_property("bodies", fmt::format("{} moving", report.bodies));
  text += format_property("joints", std::to_string(report.joints));
  text += wrap_list("spanning tree", report.tree_joints);
  text += loops_text(report);
  text += format_property("size", fmt::format("{:.6g} m, its largest dimension", characteristic_length(mechanism)));
  text += format_property("total mass", fmt::format("{:.6g} kg", report.total_mass));
  if (report.outcome.status == MotionStatus::done) {
    text += freedom_text(report);
    text += list_or_none("redundant", report.redundant);
    text += list_or_none("passive freedoms", report.passive_freedoms);
    text += format_property("centre of mass", position_text(report.com, mechanism.space) + " at the start pose");
    text += start_text(report, mechanism);
    text += modes_text(report);
  }
  for (const std::string& note : report.notes) text += "note: " + note + "\n";
  return text;
}

namespace {

std::string trajectory_text(const TrajectoryVerification& run) {
  const auto describe_outcome = [](const MotionOutcome& outcome) {
    return outcome.status == MotionStatus::done ? std::string("runs to the end") : outcome.reason;
  };
  if (run.differences.empty())
    return fmt::format(
        "trajectory {}: {}\n  tree:    {}\n  natural: {}\n", run.trajectory,
        run.is_consistent ? "both formulations reject it" : "one formulation rejects what the other runs",
        describe_outcome(run.tree), describe_outcome(run.natural));
  TextTable table;
  table.heading = {"quantity", "unit", "largest difference", "at time [s]", "relative"};
  table.align = {Align::left, Align::left, Align::right, Align::right, Align::right};
  for (const QuantityDifference& d : run.differences)
    table.rows.push_back({d.quantity, d.unit, fmt::format("{:.2e}", d.difference), format_number(d.time),
                          fmt::format("{:.1e}{}", d.relative(), d.relative() <= run.tolerance ? "" : " !")});
  const std::string tolerance_note =
      run.tolerance > verify_tolerance ? fmt::format(" (near a singularity: to {:.0e})", run.tolerance) : std::string();
  return fmt::format("trajectory {}, {} samples: {}{}\n", run.trajectory, run.samples,
                     run.is_consistent ? "agree" : "DISAGREE", tolerance_note) +
         format_table(table);
}

std::string conditions_text(const ConditionsVerification& verification) {
  if (!verification.reason.empty()) return "force conditions: not compared: " + verification.reason + "\n";
  return fmt::format("force conditions: {} by sampling, {} from the coefficient matrices; {} ({:.1e} apart)\n",
                     verification.sampled, verification.coefficients,
                     verification.is_consistent ? "the same space" : "DIFFERENT SPACES",
                     verification.subspace_angle_sine);
}

}  // namespace

std::string verify_text(const VerifyReport& report) {
  std::string text;
  for (const TrajectoryVerification& run : report.trajectories) text += trajectory_text(run) + "\n";
  text += conditions_text(report.conditions);
  text += report.is_consistent ? "both formulations agree\n" : "the formulations differ by more than round-off\n";
  return text;
}

Json verify_json(const VerifyReport& report) {
  Json json = {{"agree", report.is_consistent}, {"tolerance", verify_tolerance}, {"trajectories", Json::array()}};
  for (const TrajectoryVerification& run : report.trajectories) {
    Json differences = Json::array();
    for (const QuantityDifference& d : run.differences)
      differences.push_back({{"quantity", d.quantity},
                             {"unit", d.unit},
                             {"difference", d.difference},
                             {"time", d.time},
                             {"scale", d.scale},
                             {"relative", d.relative()}});
    json["trajectories"].push_back({{"trajectory", run.trajectory},
                                    {"agree", run.is_consistent},
                                    {"samples", run.samples},
                                    {"tolerance", run.tolerance},
                                    {"tree", outcome_json(run.tree)},
                                    {"natural", outcome_json(run.natural)},
                                    {"differences", differences}});
  }
  const ConditionsVerification& c = report.conditions;
  json["force_conditions"] = {{"agree", c.is_consistent},
                              {"by_sampling", c.sampled},
                              {"from_coefficients", c.coefficients},
                              {"apart", c.subspace_angle_sine}};
  if (!c.reason.empty()) json["force_conditions"]["reason"] = c.reason;
  return json;
}

}  // namespace balance
