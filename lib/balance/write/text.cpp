#include "balance/write/text.hpp"

#include "balance/write/found_law.hpp"
#include "balance/write/payload_changes.hpp"
#include "balance/write/state_text.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>

namespace balance {

std::string format_result_summary(const RunResult& result, const Provenance& description) {
  if (!description.pose.empty()) return format_state(result, description);
  const double duration = result.time.size() == 0 ? 0 : result.time[result.time.size() - 1] - result.time[0];
  const std::string controller =
      description.controller.empty()
          ? ""
          : fmt::format(", controller {} ({})", description.controller, description.controller_type);
  std::string text =
      fmt::format("{}: trajectory {} ({}, drive {}){}, {:.6g} s, {} samples\n\n", description.title,
                  description.trajectory, description.law, description.drive, controller, duration, result.time.size());
  if (result.corridor_result) text += format_corridor_result(*result.corridor_result) + "\n";
  if (result.optimised_law) text += format_optimised_law(*result.optimised_law) + "\n";
  if (!result.payload_events.empty()) text += format_payload_events(result) + "\n";
  TextTable table;
  table.heading = {"quantity", "unit", "peak", "at time [s]", "rms", "mean"};
  table.align = {Align::left, Align::left, Align::right, Align::right, Align::right, Align::right};
  for (const Metric& metric : result.metrics) {
    table.rows.push_back({metric.quantity, metric.unit, format_number(metric.peak), format_number(metric.peak_time),
                          format_number(metric.rms), format_number(metric.mean)});
  }
  return text + format_table(table) +
         fmt::format("\nenergy moved by the actuators: {} J\n", format_number(result.energy));
}

}  // namespace balance
