#include "balance/write/found_law.hpp"

#include "balance/write/table.hpp"

#include <fmt/format.h>

namespace balance {
namespace {

constexpr std::size_t most_lines = 40;

}  // namespace

std::string found_law_text(const FoundLaw& law) {
  if (law.momentum != 0)
    return fmt::format("law of steady momentum: {:.9g} N m s in {:.9g} s\n", law.momentum, law.duration);
  std::string text = law.of.empty() ? fmt::format("fastest law within the limits: {:.9g} s", law.duration)
                                    : fmt::format("gentlest law: peak of {} {:.9g} {} in {:.9g} s", law.of, law.peak,
                                                  law.unit, law.duration);
  text += fmt::format(", {} switch{}\n", law.switches.size(), law.switches.size() == 1 ? "" : "es");
  Table table;
  table.heading = {"from [s]", "to [s]", "path from [%]", "to [%]", "at its limit"};
  table.align = {Align::right, Align::right, Align::right, Align::right, Align::left};
  for (const LawStretch& stretch : law.stretches) {
    if (table.rows.size() == most_lines) break;
    table.rows.push_back({format_number(stretch.begin), format_number(stretch.end), format_number(100 * stretch.from),
                          format_number(100 * stretch.to), stretch.limit.empty() ? "-" : stretch.limit});
  }
  text += format_table(table);
  if (law.stretches.size() > most_lines) text += fmt::format("and {} more\n", law.stretches.size() - most_lines);
  return text;
}

Json found_law_json(const FoundLaw& law) {
  Json json = {{"duration", law.duration}, {"switches", law.switches}, {"stretches", Json::array()}};
  for (const LawStretch& stretch : law.stretches)
    json["stretches"].push_back({{"begin", stretch.begin},
                                 {"end", stretch.end},
                                 {"from", stretch.from},
                                 {"to", stretch.to},
                                 {"limit", stretch.limit.empty() ? Json(nullptr) : Json(stretch.limit)}});
  if (law.momentum != 0) json["momentum"] = law.momentum;
  if (law.of.empty()) return json;
  json["of"] = law.of;
  json["peak"] = law.peak;
  json["unit"] = law.unit;
  return json;
}

std::string found_corridor_text(const FoundCorridor& c) {
  return fmt::format(
      "corridor: the path is left by up to {0:.6g} of {1:.6g} {2}: {3} {4:.9g} {6} instead of {5:.9g} {6}; {7} of {8} "
      "starts ended there\n",
      c.used, c.width, c.width_unit, c.of == "duration" ? c.of : "peak of " + c.of, c.figure, c.on_path, c.unit,
      c.agreeing, c.starts);
}

Json found_corridor_json(const FoundCorridor& c) {
  return {{"width", c.width},     {"used", c.used},     {"unit", c.width_unit},
          {"of", c.of},           {"value", c.figure},  {"on_path", c.on_path},
          {"value_unit", c.unit}, {"starts", c.starts}, {"agreeing", c.agreeing}};
}

}  // namespace balance
