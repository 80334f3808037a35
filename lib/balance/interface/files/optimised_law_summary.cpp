#include "balance/interface/files/optimised_law_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace balance::files {
namespace {

constexpr std::size_t max_listed_intervals = 40;

}  // namespace

ReportFields<trajectory::ActiveLimitInterval> active_limit_fields() {
  using Row = trajectory::ActiveLimitInterval;
  const auto percent = [](double Row::*place) {
    return [place](const Row& interval, const DisplayUnit&) { return format_number(100 * interval.*place); };
  };
  return {
      {[](const Row& interval) { return interval.limit.empty() ? "none" : interval.limit; },
       Hdf5Dataset{"quantity at its limit", "limit"}},
      {&Row::begin, JsonKey{"begin"}, TextColumn{"from", six_digits}, SiUnit{"s"},
       Hdf5Dataset{"time at which it reaches its limit"}},
      {&Row::end, JsonKey{"end"}, TextColumn{"to", six_digits}, SiUnit{"s"},
       Hdf5Dataset{"time at which it leaves its limit"}},
      {&Row::path_begin, JsonKey{"from"}, TextColumn{"path from [%]"}, percent(&Row::path_begin), SiUnit{"1"},
       Hdf5Dataset{"place at which it reaches its limit"}},
      {&Row::path_end, JsonKey{"to"}, TextColumn{"to [%]"}, percent(&Row::path_end), SiUnit{"1"},
       Hdf5Dataset{"place at which it leaves its limit"}},
      {[](const Row& interval) { return text_or_null(interval.limit); }, JsonKey{"limit"}, TextColumn{"at its limit"},
       [](const Row& interval, const DisplayUnit&) { return interval.limit.empty() ? "-" : interval.limit; }}};
}

std::string format_optimised_law(const trajectory::OptimisedLaw& law, const TextOptions& options) {
  const DisplayUnit time = find_display_unit("s", options.units), momentum = find_display_unit("N m s", options.units),
                    peak = find_display_unit(law.unit, options.units);
  const std::string duration = fmt::format("{:.9g} {}", time.convert(law.duration), time.name);
  if (law.momentum != 0)
    return fmt::format("law of steady momentum: {:.9g} {} in {}\n", momentum.convert(law.momentum), momentum.name,
                       duration);
  std::string text = law.objective.empty()
                         ? fmt::format("fastest law within the limits: {}", duration)
                         : fmt::format("gentlest law: peak of {} {:.9g}{} in {}", law.objective,
                                       peak.convert(law.objective_value), append_unit(peak), duration);
  text += fmt::format(", {} switch{}\n", law.switch_times.size(), law.switch_times.size() == 1 ? "" : "es");
  const std::size_t listed = std::min(law.active_limits.size(), max_listed_intervals);
  text += format_table(rows_table(std::span(law.active_limits).first(listed), active_limit_fields(), options.units),
                       options.width);
  if (law.active_limits.size() > max_listed_intervals)
    text += fmt::format("and {} more\n", law.active_limits.size() - max_listed_intervals);
  return text;
}

Json optimised_law_json(const trajectory::OptimisedLaw& law) {
  Json json = {{"duration", law.duration},
               {"switches", law.switch_times},
               {"stretches", rows_json(law.active_limits, active_limit_fields())}};
  if (law.momentum != 0) json["momentum"] = law.momentum;
  if (law.objective.empty()) return json;
  json["of"] = law.objective;
  json["peak"] = law.objective_value;
  json["unit"] = law.unit;
  return json;
}

std::string format_corridor_result(const trajectory::CorridorResult& c, const specification::SpecUnits& units) {
  const DisplayUnit width = find_display_unit(c.width_unit, units), unit = find_display_unit(c.unit, units);
  return fmt::format(
      "corridor: the motion leaves the path by up to {0:.6g} of {1:.6g} {2}: {3} {4:.9g} {6} instead of {5:.9g} {6}; "
      "{7} of {8} starts converged to it\n",
      width.convert(c.max_offset), width.convert(c.width), width.name,
      c.objective == "duration" ? c.objective : "peak of " + c.objective, unit.convert(c.objective_value),
      unit.convert(c.centreline_value), unit.name, c.agreeing_starts, c.starts);
}

Json corridor_result_json(const trajectory::CorridorResult& c) {
  return {{"width", c.width},     {"used", c.max_offset},       {"unit", c.width_unit},
          {"of", c.objective},    {"value", c.objective_value}, {"on_path", c.centreline_value},
          {"value_unit", c.unit}, {"starts", c.starts},         {"agreeing", c.agreeing_starts}};
}

}  // namespace balance::files
