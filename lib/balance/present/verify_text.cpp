#include "balance/present/verify_text.hpp"

#include "balance/write/table.hpp"

#include <fmt/format.h>

namespace balance {
namespace {

std::string trajectory_text(const TrajectoryVerification& run) {
  const auto stopped = [](const MotionOutcome& outcome) {
    return outcome.status == MotionStatus::done ? std::string("runs to the end") : outcome.reason;
  };
  if (run.differences.empty())
    return fmt::format(
        "trajectory {}: {}\n  tree:    {}\n  natural: {}\n", run.trajectory,
        run.is_consistent ? "both formulations refuse it" : "one formulation refuses what the other runs",
        stopped(run.tree), stopped(run.natural));
  TextTable table;
  table.heading = {"quantity", "unit", "largest difference", "at time [s]", "relative"};
  table.align = {Align::left, Align::left, Align::right, Align::right, Align::right};
  for (const QuantityDifference& d : run.differences)
    table.rows.push_back({d.quantity, d.unit, fmt::format("{:.2e}", d.difference), format_number(d.time),
                          fmt::format("{:.1e}{}", d.relative(), d.relative() <= run.tolerance ? "" : " !")});
  const std::string near =
      run.tolerance > verify_tolerance ? fmt::format(" (near a singularity: to {:.0e})", run.tolerance) : std::string();
  return fmt::format("trajectory {}, {} samples: {}{}\n", run.trajectory, run.samples,
                     run.is_consistent ? "agree" : "DISAGREE", near) +
         format_table(table);
}

std::string conditions_text(const ConditionsVerification& found) {
  if (!found.reason.empty()) return "force conditions: not compared: " + found.reason + "\n";
  return fmt::format("force conditions: {} by sampling, {} from the coefficient matrices; {} ({:.1e} apart)\n",
                     found.sampled, found.coefficients, found.is_consistent ? "the same space" : "DIFFERENT SPACES",
                     found.subspace_angle_sine);
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
