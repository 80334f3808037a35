#include "spec_run.hpp"

#include "failure.hpp"

#include "balance/base/nearest.hpp"

#include <filesystem>

namespace balance::app {

std::optional<SpecRun> spec_run_of(const std::string& name) {
  if (name == "-") return SpecRun{name, ""};
  std::error_code ignored;
  const bool exists = std::filesystem::exists(name, ignored);
  for (const std::string suffix : {".yaml", ".yml"}) {
    if (name.ends_with(suffix)) return SpecRun{name, ""};
    if (exists) continue;
    if (const std::size_t at = name.rfind(suffix + ":"); at != std::string::npos)
      return SpecRun{name.substr(0, at + suffix.size()), name.substr(at + suffix.size() + 1)};
  }
  return std::nullopt;
}

void take_trajectory(std::string& spec, std::string& trajectory) {
  const std::optional<SpecRun> named = spec_run_of(spec);
  if (!named || named->trajectory.empty()) return;
  if (!trajectory.empty() && trajectory != named->trajectory)
    throw UsageError("two trajectories are named: " + in_quotes(named->trajectory) + " and " + in_quotes(trajectory));
  spec = named->spec;
  trajectory = named->trajectory;
}

}  // namespace balance::app
