#include "balance/present/check_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace balance {
namespace {

constexpr std::size_t label_width = 20;
constexpr std::size_t line_width = 100;

/// A long name widens its own line: a space is between it and the value all the same.
std::string format_property(const std::string& label, const std::string& value) {
  return fmt::format("{:<{}} {}\n", label, label_width - 1, value);
}

/// Items between commas, on as many lines as they need.
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

std::string plural(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string plural(int count, const char* one, const char* several) {
  return fmt::format("{} {}", count, count == 1 ? one : several);
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
    text += format_property("  cut at " + loop.cut_joint,
                            fmt::format("{}; {}", fmt::join(loop.bodies, " - "), plural(loop.constraints, "equation")));
  }
  return text;
}

std::string freedom_text(const CheckReport& report) {
  const std::string by_rank =
      report.closure_equations == 0
          ? plural(report.tree_coordinates, "coordinate")
          : fmt::format("{} - {} independent of {}", plural(report.tree_coordinates, "coordinate"), report.closure_rank,
                        plural(report.closure_equations, "closure equation"));
  if (report.rate_equations == 0)
    return format_property("degrees of freedom", fmt::format("{} ({}); by counting {}", report.degrees_of_freedom,
                                                             by_rank, report.gruebler_degrees_of_freedom));
  return format_property("degrees of freedom",
                         fmt::format("{} of the configuration ({}); by counting {}", report.configuration_freedoms,
                                     by_rank, report.gruebler_degrees_of_freedom)) +
         format_property("",
                         fmt::format("{} of the velocity ({} less, by {})", report.degrees_of_freedom, report.rate_rank,
                                     plural(report.rate_equations, "equation of rates", "equations of rates")));
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
                        mode.is_selected ? "   # the one that the spec picks" : "");
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

}  // namespace balance
