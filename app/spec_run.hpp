#pragma once
/// Specs that are named with one of their trajectories: `arm.yaml:cycloid`.

#include <optional>
#include <string>

namespace balance::app {

struct SpecTrajectoryName {
  std::string spec, trajectory;  ///< the trajectory may be empty
};

/// Nothing if the name is none of a spec. Standard input, `-`, is one, of which no trajectory can be named. A file that has a colon in its name is that file.
std::optional<SpecTrajectoryName> parse_spec_trajectory_name(const std::string& name);

/// Takes the trajectory off a spec's name. @throws UsageError if another is named already
void split_trajectory_name(std::string& spec, std::string& trajectory);

}  // namespace balance::app
