#include "balance/interface/reports/check_sections.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/interface/reports/vibration_sections.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>

namespace balance::reports {
namespace {

Json loop_json(const verification::Loop& loop) {
  return {{"cut_joint", loop.cut_joint}, {"bodies", loop.bodies}, {"closure_equations", loop.constraints}};
}

Json coordinates_json(const std::vector<double>& values, const Mechanism& mechanism) {
  Json json = Json::object();
  if (values.size() != mechanism.coordinates.size()) return json;
  for (std::size_t i = 0; i < values.size(); ++i) json[mechanism.coordinates[i].name] = values[i];
  return json;
}

Json mode_json(const verification::AssemblyMode& mode, const Mechanism& mechanism) {
  return {{"coordinates", coordinates_json(mode.coordinates, mechanism)},
          {"assembly", mode.assembly_line},
          {"selected", mode.is_selected},
          {"motions", mode.motions}};
}

Json correction_plane_json(const simulation::CorrectionPlane& plane) {
  return {{"name", plane.name},
          {"position", plane.position},
          {"unbalance", plane.unbalance.magnitude},
          {"angle", plane.unbalance.angle},
          {"share", plane.share}};
}

Json rotor_quality_json(const simulation::RotorQuality& quality) {
  return {{"trajectory", quality.trajectory},
          {"speed", quality.speed},
          {"quality", quality.quality},
          {"grade", quality.grade > 0 ? Json(quality.grade) : Json()}};
}

Json rotor_json(const simulation::RotorUnbalance& rotor) {
  Json json = {{"body", rotor.body},
               {"joint", rotor.joint},
               {"mass", rotor.mass},
               {"angle_reference", rotor.angle_reference},
               {"static_unbalance", rotor.static_unbalance.magnitude},
               {"static_angle", rotor.static_unbalance.angle},
               {"eccentricity", rotor.eccentricity}};
  json["couple_unbalance"] = rotor.is_spatial ? Json(rotor.couple_unbalance.magnitude) : Json();
  json["couple_angle"] = rotor.is_spatial ? Json(rotor.couple_unbalance.angle) : Json();
  json["planes"] = files::list_json(rotor.planes, correction_plane_json);
  json["qualities"] = files::list_json(rotor.qualities, rotor_quality_json);
  return json;
}

ReportFields<verification::QuantityDifference> difference_fields(double tolerance) {
  using Row = verification::QuantityDifference;
  return {{&Row::quantity, JsonKey{"quantity"}, TextColumn{}},
          {&Row::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name_or_1},
          {&Row::difference, JsonKey{"difference"}, TextColumn{"largest difference", "{:.2e}"}},
          {&Row::time, JsonKey{"time"}, TextColumn{"at time", files::six_digits}, SiUnit{"s"}},
          {&Row::scale, JsonKey{"scale"}},
          {&Row::relative, JsonKey{"relative"}, TextColumn{}, [=](const Row& row, const files::DisplayUnit&) {
             return fmt::format("{:.1e}{}", row.relative(), row.relative() <= tolerance ? "" : " !");
           }}};
}

Json verify_json(const verification::VerifyReport& report) {
  Json json = {
      {"agree", report.is_consistent}, {"tolerance", verification::verify_tolerance}, {"trajectories", Json::array()}};
  for (const verification::TrajectoryVerification& run : report.trajectories)
    json["trajectories"].push_back({{"trajectory", run.trajectory},
                                    {"agree", run.is_consistent},
                                    {"samples", run.samples},
                                    {"tolerance", run.tolerance},
                                    {"tree", files::outcome_json(run.tree)},
                                    {"natural", files::outcome_json(run.natural)},
                                    {"differences", rows_json(run.differences, difference_fields(run.tolerance))}});
  const verification::ConditionsVerification& c = report.conditions;
  json["force_conditions"] = {{"agree", c.is_consistent},
                              {"by_sampling", c.sampled},
                              {"from_coefficients", c.coefficients},
                              {"apart", c.subspace_angle_sine}};
  if (!c.reason.empty()) json["force_conditions"]["reason"] = c.reason;
  return json;
}

}  // namespace

Json check_json(const CheckReport& report, const Mechanism& mechanism, const std::vector<std::string>& warnings,
                const verification::VerifyReport* verification) {
  const bool planar = mechanism.space == SpaceKind::planar;
  Json json = {{"mechanism", mechanism.name}, {"space", planar ? "planar" : "spatial"}};
  json["outcome"] = files::outcome_json(report.outcome);
  json["bodies"] = report.bodies;
  json["joints"] = report.joints;
  json["tree_joints"] = report.tree_joints;
  json["loops"] = files::list_json(report.loops, loop_json);
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
  json["com"] = files::vector_json(report.com, planar ? 2 : 3);
  json["start"] = coordinates_json(report.start, mechanism);
  json["modes"] = files::list_json(report.modes,
                                   [&](const verification::AssemblyMode& mode) { return mode_json(mode, mechanism); });
  json["rotors"] = files::list_json(report.rotors, rotor_json);
  json["vibrations"] = files::list_json(
      report.vibrations, [&](const vibration::VibrationModes& one) { return vibration_json(one, mechanism); });
  json["notes"] = report.notes;
  json["warnings"] = warnings;
  if (verification != nullptr) json["verification"] = verify_json(*verification);
  return json;
}

namespace {

constexpr std::size_t label_width = 20;

/// A long label widens its own line; a space always separates it from the value.
std::string format_property(const std::string& label, const std::string& value, std::size_t width) {
  const std::string begin = fmt::format("{:<{}} ", label, label_width - 1);
  std::string text;
  for (const std::string& line : files::wrap_cell(value, width > begin.size() + 20 ? width - begin.size() : width))
    text += (text.empty() ? begin : std::string(label_width, ' ')) + line + "\n";
  return text;
}

/// Items separated by commas, on as many lines as needed.
std::string wrap_list(const std::string& label, const std::vector<std::string>& items, std::size_t width) {
  std::string text, current;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string item = items[i] + (i + 1 < items.size() ? "," : "");
    if (!current.empty() && label_width + current.size() + 1 + item.size() > width) {
      text += format_property(text.empty() ? label : "", current, width);
      current.clear();
    }
    current += (current.empty() ? "" : " ") + item;
  }
  return text + format_property(text.empty() ? label : "", current, width);
}

std::string none_text(const std::string& label, const files::TextOptions& options) {
  return options.verbose ? format_property(label, "none", options.width) : "";
}

std::string list_or_none(const std::string& label, const std::vector<std::string>& items,
                         const files::TextOptions& options) {
  if (items.empty()) return none_text(label, options);
  std::string text;
  for (const std::string& item : items)
    text += format_property(&item == &items.front() ? label : "", item, options.width);
  return text;
}

std::string loops_text(const CheckReport& report, const files::TextOptions& options) {
  if (report.loops.empty()) return none_text("loops", options);
  std::string text = format_property("loops", std::to_string(report.loops.size()), options.width);
  for (const verification::Loop& loop : report.loops) {
    text += format_property(
        "  cut at " + loop.cut_joint,
        fmt::format("{}; {}", fmt::join(loop.bodies, " - "), count_noun(loop.constraints, "equation", "equations")),
        options.width);
  }
  return text;
}

std::string freedom_text(const CheckReport& report, std::size_t width) {
  const std::string by_rank =
      report.closure_equations == 0
          ? count_noun(report.tree_coordinates, "coordinate", "coordinates")
          : fmt::format("{} - {} independent of {}", count_noun(report.tree_coordinates, "coordinate", "coordinates"),
                        report.closure_rank,
                        count_noun(report.closure_equations, "closure equation", "closure equations"));
  if (report.rate_equations == 0)
    return format_property(
        "degrees of freedom",
        fmt::format("{} ({}); by counting {}", report.degrees_of_freedom, by_rank, report.gruebler_degrees_of_freedom),
        width);
  return format_property("degrees of freedom",
                         fmt::format("{} of the configuration ({}); by counting {}", report.configuration_freedoms,
                                     by_rank, report.gruebler_degrees_of_freedom),
                         width) +
         format_property("",
                         fmt::format("{} of the velocity ({} less, by {})", report.degrees_of_freedom, report.rate_rank,
                                     count_noun(report.rate_equations, "equation of rates", "equations of rates")),
                         width);
}

std::string start_text(const CheckReport& report, const Mechanism& mechanism, const files::TextOptions& options) {
  if (report.start.size() != mechanism.coordinates.size() || report.start.empty()) return "";
  std::vector<std::string> values;
  for (std::size_t i = 0; i < report.start.size(); ++i) {
    const Coordinate& coordinate = mechanism.coordinates[i];
    const files::DisplayUnit unit =
        files::find_display_unit(coordinate.kind == CoordinateKind::angle ? "rad" : "m", options.units);
    values.push_back(fmt::format("{} = {:.6g} {}", coordinate.name, unit.convert(report.start[i]), unit.name));
  }
  return wrap_list("start pose", values, options.width);
}

/// A line of YAML, continued after a comma of its flow mapping: a pair of name and value stays whole.
std::string wrap_flow_mapping(const std::string& begin, const std::string& mapping, const std::string& comment,
                              std::size_t width) {
  std::vector<std::string> pairs;
  for (std::size_t at = 0; at < mapping.size();) {
    const std::size_t comma = mapping.find(", ", at);
    const std::size_t end = comma == std::string::npos ? mapping.size() : comma + 2;
    pairs.push_back(mapping.substr(at, end - at));
    at = end;
  }
  if (!comment.empty()) pairs.push_back("   # " + comment);
  const std::size_t indent = begin.size() + 2;
  std::string text, line = begin;
  bool is_begun = false;
  for (const std::string& pair : pairs) {
    const std::size_t printed_size = pair.find_last_not_of(' ') + 1;  // a blank at the end of a line is not printed
    if (is_begun && line.size() + printed_size > width) {
      text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
      line = std::string(indent, ' ') + pair.substr(pair.find_first_not_of(' '));
    } else {
      line += pair;
    }
    is_begun = true;
  }
  return text + line + "\n";
}

std::string modes_text(const CheckReport& report, std::size_t width) {
  if (report.modes.empty()) return "";
  std::string text =
      format_property("assembly modes", fmt::format("{} found at the start pose", report.modes.size()), width);
  for (const verification::AssemblyMode& mode : report.modes) {
    if (mode.assembly_line.empty()) continue;  // nothing to choose
    std::string comment = mode.is_selected ? "selected by the spec" : "";
    if (!mode.motions.empty())
      comment += fmt::format("{}can follow {}", comment.empty() ? "" : "; ", fmt::join(mode.motions, ", "));
    text += wrap_flow_mapping(mode.is_selected ? "  * " : "    ", mode.assembly_line, comment, width);
  }
  return text;
}

/// "12 kg m at 267.5 deg"; "none"
std::string unbalance_text(const simulation::UnbalanceVector& unbalance, const char* unit,
                           const files::TextOptions& options) {
  if (unbalance.magnitude == 0) return "none";
  const files::DisplayUnit of_size = files::find_display_unit(unit, options.units),
                           of_angle = files::find_display_unit("rad", options.units);
  return fmt::format("{:.6g} {} at {:.6g} {}", of_size.convert(unbalance.magnitude), of_size.name,
                     of_angle.convert(unbalance.angle), of_angle.name);
}

std::string quality_text(const simulation::RotorQuality& quality, const files::TextOptions& options) {
  const files::DisplayUnit speed = files::find_display_unit("rad/s", options.units);
  const double turns_per_minute = 60 * quality.speed / (2 * std::numbers::pi);
  return fmt::format("G = {:.4g} mm/s at {:.6g} {} ({:.6g}/min); {}", quality.quality, speed.convert(quality.speed),
                     speed.name, turns_per_minute,
                     quality.grade > 0 ? fmt::format("within G {:g}", quality.grade) : "outside G 4000");
}

/// Unbalance in the words of ISO 21940.
std::string rotor_text(const simulation::RotorUnbalance& rotor, const files::TextOptions& options) {
  const std::size_t width = options.width;
  const files::DisplayUnit length = files::find_display_unit("m", options.units),
                           mass = files::find_display_unit("kg", options.units);
  std::string text = format_property("rotor " + rotor.body,
                                     fmt::format("{:.6g} {} on {}; angles from {}.{}", mass.convert(rotor.mass),
                                                 mass.name, rotor.joint, rotor.body, rotor.angle_reference),
                                     width);
  std::string eccentricity;
  if (rotor.eccentricity > 0)
    eccentricity = fmt::format(", eccentricity {:.6g} {}", length.convert(rotor.eccentricity), length.name);
  text += format_property("  static unbalance", unbalance_text(rotor.static_unbalance, "kg m", options) + eccentricity,
                          width);
  if (rotor.is_spatial)
    text += format_property("  couple unbalance", unbalance_text(rotor.couple_unbalance, "kg m^2", options), width);
  for (const simulation::CorrectionPlane& plane : rotor.planes)
    text +=
        format_property(fmt::format("  plane at {:.6g} {}", length.convert(plane.position), length.name),
                        fmt::format("{} ({})", unbalance_text(plane.unbalance, "kg m", options), plane.name), width);
  for (const simulation::RotorQuality& quality : rotor.qualities)
    text += format_property("  along " + quality.trajectory, quality_text(quality, options), width);
  return text;
}

}  // namespace

std::string check_text(const CheckReport& report, const Mechanism& mechanism, const files::TextOptions& options) {
  const std::size_t width = options.width;
  const files::DisplayUnit length = files::find_display_unit("m", options.units),
                           mass = files::find_display_unit("kg", options.units);
  std::string text =
      fmt::format("{} ({})\n\n", mechanism.name, mechanism.space == SpaceKind::planar ? "planar" : "spatial");
  text += format_property("bodies", fmt::format("{} moving", report.bodies), width);
  text += format_property("joints", std::to_string(report.joints), width);
  text += wrap_list("spanning tree", report.tree_joints, width);
  text += loops_text(report, options);
  text += format_property(
      "size",
      fmt::format("{:.6g} {}, its largest dimension", length.convert(characteristic_length(mechanism)), length.name),
      width);
  text += format_property("total mass", fmt::format("{:.6g} {}", mass.convert(report.total_mass), mass.name), width);
  if (report.outcome.status == MotionStatus::done) {
    const int axes = mechanism.space == SpaceKind::planar ? 2 : 3;
    text += freedom_text(report, width);
    text += list_or_none("redundant", report.redundant, options);
    text += list_or_none("passive freedoms", report.passive_freedoms, options);
    text += format_property("centre of mass",
                            format_position(report.com.data(), axes, options.units) + " at the start pose", width);
    text += start_text(report, mechanism, options);
    text += modes_text(report, width);
  }
  for (const simulation::RotorUnbalance& rotor : report.rotors) text += rotor_text(rotor, options);
  for (const vibration::VibrationModes& one : report.vibrations)
    text += vibration_text(one, mechanism, "vibrations", label_width, options);
  for (const std::string& note : report.notes) text += files::wrap_lines("note: " + note + "\n", width);
  return text;
}

namespace {

std::string trajectory_text(const verification::TrajectoryVerification& run, const files::TextOptions& options) {
  const auto describe_outcome = [](const MotionOutcome& outcome) {
    return outcome.status == MotionStatus::done ? std::string("runs to the end") : outcome.reason;
  };
  if (run.differences.empty())
    return fmt::format(
        "trajectory {}: {}\n  tree:    {}\n  natural: {}\n", run.trajectory,
        run.is_consistent ? "both formulations reject it" : "one formulation rejects what the other runs",
        describe_outcome(run.tree), describe_outcome(run.natural));
  files::TextTable table = rows_table(run.differences, difference_fields(run.tolerance), options.units);
  table.key_columns = 2;
  const std::string tolerance_note = run.tolerance > verification::verify_tolerance
                                         ? fmt::format(" (near a singularity: to {:.0e})", run.tolerance)
                                         : std::string();
  return fmt::format("trajectory {}, {} samples: {}{}\n", run.trajectory, run.samples,
                     run.is_consistent ? "agree" : "DISAGREE", tolerance_note) +
         format_table(table, options.width);
}

std::string conditions_text(const verification::ConditionsVerification& verification) {
  if (!verification.reason.empty()) return "force conditions: not compared: " + verification.reason + "\n";
  return fmt::format("force conditions: {} by sampling, {} from the coefficient matrices; {} ({:.1e} apart)\n",
                     verification.sampled, verification.coefficients,
                     verification.is_consistent ? "the same space" : "DIFFERENT SPACES",
                     verification.subspace_angle_sine);
}

}  // namespace

std::string verify_text(const verification::VerifyReport& report, const files::TextOptions& options) {
  std::string text;
  for (const verification::TrajectoryVerification& run : report.trajectories)
    text += trajectory_text(run, options) + "\n";
  text += conditions_text(report.conditions);
  text += report.is_consistent ? "both formulations agree\n" : "the formulations differ by more than round-off\n";
  return files::wrap_lines(text, options.width);
}

}  // namespace balance::reports
