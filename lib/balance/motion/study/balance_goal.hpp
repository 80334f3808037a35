#pragma once
/// Balancing goals.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>
#include <string>
#include <string_view>
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
  order,                   ///< an order of a force, a moment or another affine quantity along a periodic motion
};

/// An order of a quantity along a motion in which a coordinate turns uniformly by whole turns.
struct OrderReference {
  double number = 1;  ///< times per turn: positive, a multiple of 1/turns
  results::OrderPart part = results::OrderPart::whole;
  std::string quantity = {};    ///< "shaking_force", "shaking_moment[x] about ground.M", "torque[A]"
  std::string trajectory = {};  ///< its name

  bool operator==(const OrderReference&) const = default;
};

/// Written `fully-static`, `force[y]`, `moment[x] about ground.M`, `constant-speed-dynamic`,
/// `constant-speed-moment[x] of A and B about ground.M`, `order 2 of shaking_force along run`.
struct Goal {
  GoalKind kind = GoalKind::statics;
  bool is_fully = false;  ///< in addition, the inertia at the actuators is the same in every configuration
  /// Of force, moment, dynamic: what vanishes is the rate of the momentum while some coordinates turn or slide at
  /// constant speed. Freedoms that these do not determine may accelerate.
  bool is_at_constant_speed = false;
  int component = -1;  ///< of force or moment: 0, 1 or 2 along the ground's axes; −1: all
  /// At constant speed; empty: all driven ones (list_constant_speed_coordinates).
  std::vector<std::string> coordinates = {};
  std::string about = {};     ///< of moment: landmark on the ground; empty: the reference point of the runs' moments
  OrderReference order = {};  ///< of the goal `order` alone

  bool operator==(const Goal&) const = default;
};

/// Whether a goal is none of the forms that require less: at constant speed, of a component,
/// about a stated point, an order.
bool is_whole(const Goal& goal);
/// Whether a goal requires that the whole linear momentum vanishes.
bool requires_zero_momentum(const Goal& goal);
/// The same of the whole angular momentum about the reference point of the runs' moments.
bool requires_zero_angular_momentum(const Goal& goal);

/// The goal that a text means; std::nullopt if it means none.
std::optional<Goal> find_goal(const std::string& text);
std::string goal_name(const Goal& goal);
/// All names, without components, coordinates and reference points.
const std::vector<std::string>& goal_names();

/// What is wrong with a goal: expected X, found Y; hint.
struct GoalMistake {
  std::string expected;
  std::string found;
  std::string hint;  ///< empty: none

  /// "expected x, y or z, found 'w'"
  std::string sentence() const;
};

/// What a mechanism and its trajectories lack for a goal of an order: a motion of that name that prescribes everything and
/// may be periodic. Whether it is shows when it is followed. Empty for other goals.
std::optional<GoalMistake> find_motion_mistake(const Goal& goal, const std::vector<Trajectory>& trajectories);

/// The trajectories that goals name, each once.
std::vector<Trajectory> select_goal_motions(const std::vector<Goal>& goals,
                                            const std::vector<Trajectory>& trajectories);

/// The number of an order: 2, 0.5 or 1/2. Not above 0, or no number: std::nullopt.
std::optional<double> find_order_number(std::string_view text);

/// Why a text means no goal.
GoalMistake explain_goal_mistake(const std::string& text);

/// What a mechanism lacks for a goal: the component, a coordinate, the reference point.
std::optional<GoalMistake> find_goal_mistake(const Goal& goal, const Mechanism& mechanism);

/// Why a text means no goal of a mechanism and its trajectories.
std::optional<GoalMistake> find_goal_mistake(const std::string& text, const Mechanism& mechanism,
                                             const std::vector<Trajectory>& trajectories);

/// The coordinates whose speed a goal takes as constant: the named ones (in a disjoint union, of every mechanism), or the
/// actuated ones. Empty without actuators:
/// then all independent coordinates of an open chain are meant.
std::vector<CoordinateId> list_constant_speed_coordinates(const Goal& goal, const Mechanism& mechanism);

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
