#include "balance/interface/files/torque_distribution_summary.hpp"

#include <fmt/format.h>

namespace balance::files {

namespace {

std::string bounds_text(const std::optional<double>& lower, const std::optional<double>& upper,
                        const DisplayUnit& unit) {
  if (lower && upper) return fmt::format("{:.6g} to {:.6g} {}", unit.convert(*lower), unit.convert(*upper), unit.name);
  if (lower) return fmt::format("at least {:.6g} {}", unit.convert(*lower), unit.name);
  return fmt::format("at most {:.6g} {}", unit.convert(*upper), unit.name);
}

}  // namespace

std::string format_torque_distribution(const RunResult& result, const specification::SpecUnits& units) {
  const results::TorqueDistributionRecord& record = *result.torque_distribution;
  std::string text = "torque distribution: " + model::describe_distribution(std::optional(record.distribution)) + "\n";
  const bool is_weighted = record.distribution.is_weighted();
  for (std::size_t a = 0; a < record.distribution.shares.size(); ++a) {
    const model::EffortShare& share = record.distribution.shares[a];
    const std::optional<double> lower = share.lower_bound(), upper = share.upper_bound();
    const DisplayUnit unit = find_display_unit(result.actuator_units[a], units);
    std::string line = is_weighted ? fmt::format(", weight {:.6g}", share.weight) : "";
    if (lower || upper) line += ", " + bounds_text(lower, upper, unit);
    for (const results::BoundExcess& excess : record.excesses)
      if (excess.actuator == static_cast<int>(a))
        line += fmt::format(", exceeded by up to {:.6g} {}", unit.convert(excess.excess), unit.name);
    if (!line.empty()) text += fmt::format("  {}: {}\n", result.actuator_names[a], line.substr(2));
  }
  return text;
}

Json torque_distribution_json(const RunResult& result) {
  const results::TorqueDistributionRecord& record = *result.torque_distribution;
  Json json = {{"method", name_of(record.distribution.method)}, {"excesses", Json::array()}};
  const auto number_or_null = [](const std::optional<double>& x) { return x ? Json(*x) : Json(); };
  for (std::size_t a = 0; a < record.distribution.shares.size(); ++a) {
    const model::EffortShare& share = record.distribution.shares[a];
    const std::string& name = result.actuator_names[a];
    json["weights"][name] = share.weight;
    if (share.lower || share.upper)
      json["limits"][name] = Json::array({number_or_null(share.lower), number_or_null(share.upper)});
    if (share.preload) json["preload"][name] = *share.preload;
  }
  for (const results::BoundExcess& excess : record.excesses) {
    const auto a = static_cast<std::size_t>(excess.actuator);
    json["excesses"].push_back({{"actuator", result.actuator_names[a]},
                                {"unit", result.actuator_units[a]},
                                {"excess", excess.excess},
                                {"time", excess.time},
                                {"torque", excess.effort},
                                {"bound", excess.bound},
                                {"from", excess.first_time},
                                {"until", excess.last_time}});
  }
  return json;
}

}  // namespace balance::files
