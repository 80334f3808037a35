#pragma once
/// What a mechanism can be balanced for.

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// What must vanish for every configuration and every velocity that the joints allow (P0 Definition 2.1, P3 eq. 53–60):
enum class GoalKind {
  statics,                 ///< the actuators' efforts at rest
  gyroscopic,              ///< and their velocity terms, written in the accelerations of all tree coordinates
  gyroscopic_independent,  ///< and their velocity terms, written in the actuators' accelerations
  decoupled,               ///< gyroscopic, and the inertia by which one actuator's acceleration loads another
  force,                   ///< the linear momentum
  moment,                  ///< the angular momentum
  dynamic,                 ///< both momenta
  proportional,            ///< what the CoM's velocity differs by from a constant matrix times the tool's
  affine,                  ///< the same when constant multiples of the tool body's axes are allowed besides
};

struct Goal {
  GoalKind kind = GoalKind::statics;
  bool is_fully = false;  ///< besides, the inertia that the actuators feel is the same in every configuration

  bool operator==(const Goal&) const = default;
};

/// The goal of a name such as `gyroscopic-independent` or `fully-decoupled`.
std::optional<Goal> find_goal(const std::string& name);
std::string goal_name(const Goal& goal);
/// All names that find_goal knows.
const std::vector<std::string>& goal_names();

/// "static, force": the goals' names between commas.
std::string join_goal_names(const std::vector<Goal>& goals);

/// What a goal means, as the end of a sentence: "the actuators carry no weight, whatever the configuration".
std::string describe_goal(const Goal& goal);

}  // namespace balance
