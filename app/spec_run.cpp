#include "spec_run.hpp"

#include "failure.hpp"

#include "balance/base/nearest.hpp"

#include <filesystem>

namespace balance::app {

std::optional<SpecTrajectoryName> parse_spec_trajectory_name(const std::string& name) {
  if (name == "-") return SpecTrajectoryName{name, ""};
  std::error_code ignored;
  const bool exists = std::filesystem::exists(name, ignored);
  for (const std::string suffix : {".yaml", ".yml"}) {
    if (name.ends_with(suffix)) return SpecTrajectoryName{name, ""};
    if (exists) continue;
    if (const std::size_t at = name.rfind(suffix + ":"); at != std::string::npos)
      return SpecTrajectoryName{name.substr(0, at + suffix.size()), name.substr(at + suffix.size() + 1)};
  }
  return std::nullopt;
}

void split_trajectory_name(std::string& spec, std::string& trajectory) {
  const std::optional<SpecTrajectoryName> named = parse_spec_trajectory_name(spec);
  if (!named || named->trajectory.empty()) return;
  if (!trajectory.empty() && trajectory != named->trajectory)
    throw UsageError("two trajectories are named: " + quote_for_message(named->trajectory) + " and " +
                     quote_for_message(trajectory));
  spec = named->spec;
  trajectory = named->trajectory;
}

}  // namespace balance::app
