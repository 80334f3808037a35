#pragma once
/// Balancing goals.

#include <optional>
#include <string>
#include <vector>

namespace balance::study {

/// What must vanish for every configuration and every velocity that the joints allow (P0 Definition 2.1, P3 eq. 53–60):
enum class GoalKind {
  statics,                 ///< the actuators' efforts at rest
  gyroscopic,              ///< also their velocity terms, written in the accelerations of all tree coordinates
  gyroscopic_independent,  ///< also their velocity terms, written in the actuators' accelerations
  decoupled,               ///< gyroscopic, and the inertial coupling between actuators
  force,                   ///< the linear momentum
  moment,                  ///< the angular momentum
  dynamic,                 ///< both momenta
  proportional,            ///< difference between the CoM's velocity and a constant matrix times the tool's
  affine,                  ///< the same, with constant multiples of the tool body's axes allowed in addition
};

struct Goal {
  GoalKind kind = GoalKind::statics;
  bool is_fully = false;  ///< in addition, the inertia at the actuators is the same in every configuration

  bool operator==(const Goal&) const = default;
};

/// The goal of a name such as `gyroscopic-independent` or `fully-decoupled`; std::nullopt if there is none.
std::optional<Goal> find_goal(const std::string& name);
std::string goal_name(const Goal& goal);
/// All names that find_goal knows.
const std::vector<std::string>& goal_names();

/// "static, force": the goals' names, separated by commas.
std::string join_goal_names(const std::vector<Goal>& goals);

/// Meaning of a goal, as the end of a sentence: "the actuators carry no weight, whatever the configuration".
/// @param speeds those in whose derivatives the efforts are written; empty: as the goal says
std::string describe_goal(const Goal& goal, const std::string& speeds = "");

}  // namespace balance::study

namespace balance {

using study::Goal;
using study::GoalKind;

}  // namespace balance
