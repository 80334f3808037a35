#include "balance/motion/study/balance_goal.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/mechanics/dynamics/force_regressor.hpp"
#include "balance/mechanics/model/landmark.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/run_quantities.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

namespace balance::study {

namespace {

using namespace std::string_view_literals;

constexpr std::array base_goal_names = {
    std::pair{GoalKind::statics, "static"sv},
    std::pair{GoalKind::gyroscopic, "gyroscopic"sv},
    std::pair{GoalKind::gyroscopic_independent, "gyroscopic-independent"sv},
    std::pair{GoalKind::decoupled, "decoupled"sv},
    std::pair{GoalKind::force, "force"sv},
    std::pair{GoalKind::moment, "moment"sv},
    std::pair{GoalKind::dynamic, "dynamic"sv},
    std::pair{GoalKind::proportional, "proportional"sv},
    std::pair{GoalKind::affine, "affine"sv},
};

constexpr std::string_view fully_prefix = "fully-", constant_speed_prefix = "constant-speed-";
constexpr std::string_view of_word = " of ", and_word = " and ", about_word = " about ";
constexpr std::string_view order_word = "order ", along_word = " along ";
constexpr std::string_view components = "xyz";

/// P0 defines "fully" for goals of the actuators only.
bool can_be_fully(GoalKind kind) { return kind <= GoalKind::decoupled; }

bool has_momentum(GoalKind kind) {
  return kind == GoalKind::force || kind == GoalKind::moment || kind == GoalKind::dynamic;
}

/// The name without component, coordinates and reference point.
std::string base_name(const Goal& goal) {
  const auto entry =
      std::find_if(base_goal_names.begin(), base_goal_names.end(), [&](const auto& p) { return p.first == goal.kind; });
  std::string name(goal.is_fully ? fully_prefix : goal.is_at_constant_speed ? constant_speed_prefix : ""sv);
  return name.append(entry->second);
}

/// "y"; empty: all components.
std::string component_name(const Goal& goal) {
  return goal.component < 0 ? "" : std::string(1, components[static_cast<std::size_t>(goal.component)]);
}

/// "A and B"
std::string join_coordinates(const Goal& goal) {
  std::string text;
  for (const std::string& name : goal.coordinates) text.append(text.empty() ? "" : and_word).append(name);
  return text;
}

/// All goals without components, coordinates and reference points.
std::vector<Goal> list_base_goals() {
  std::vector<Goal> goals;
  for (const auto& [kind, name] : base_goal_names) goals.push_back({.kind = kind});
  for (const auto& [kind, name] : base_goal_names)
    if (has_momentum(kind)) goals.push_back({.kind = kind, .is_at_constant_speed = true});
  for (const auto& [kind, name] : base_goal_names)
    if (can_be_fully(kind)) goals.push_back({.kind = kind, .is_fully = true});
  return goals;
}

struct GoalReading {
  std::optional<Goal> goal;
  GoalMistake mistake;  ///< unless there is a goal
};

GoalReading fail(std::string expected, std::string_view found, std::string hint = "") {
  return {std::nullopt, {std::move(expected), quote_for_message(found), std::move(hint)}};
}

/// The text before a word, which is cut off together with what follows it.
std::optional<std::string> cut_off(std::string& text, std::string_view word) {
  const std::size_t at = text.find(word);
  if (at == std::string::npos) return std::nullopt;
  std::string rest(trim(std::string_view(text).substr(at + word.size())));
  text = std::string(trim(std::string_view(text).substr(0, at)));
  return rest;
}

/// `order 2 of shaking_force along run`, `backward order 1/2 of …`; none: the text begins in another way.
std::optional<GoalReading> read_order_goal(const std::string& given) {
  std::string text(trim(given));
  Goal goal{.kind = GoalKind::order};
  for (const results::OrderPart part : {results::OrderPart::forward, results::OrderPart::backward})
    if (text.starts_with(results::name_of(part))) {
      goal.order.part = part;
      text.erase(0, std::string_view(results::name_of(part)).size() + 1 - order_word.size());
    }
  if (!text.starts_with(order_word)) return std::nullopt;
  text.erase(0, order_word.size());
  const std::string form = "'order NUMBER of QUANTITY along TRAJECTORY', such as 'order 2 of shaking_force along run'";
  const std::optional<std::string> trajectory = cut_off(text, along_word), quantity = cut_off(text, of_word);
  if (!quantity || quantity->empty()) return fail(form, given);
  if (!trajectory || trajectory->empty()) return fail("'along' and a trajectory after " + *quantity, given, form);
  const std::optional<double> number = find_order_number(text);
  if (!number) return fail("an order, a number above 0 such as 2 or 1/2", text);
  goal.order.number = *number;
  goal.order.quantity = *quantity;
  goal.order.trajectory = *trajectory;
  return GoalReading{goal, {}};
}

GoalReading read_goal(const std::string& given) {
  if (std::optional<GoalReading> order = read_order_goal(given)) return *std::move(order);
  std::string text(trim(given));
  const std::optional<std::string> about = cut_off(text, about_word), of = cut_off(text, of_word);
  std::string component;
  if (const std::size_t bracket = text.find('['); bracket != std::string::npos && text.ends_with(']')) {
    component = std::string(trim(std::string_view(text).substr(bracket + 1, text.size() - bracket - 2)));
    if (component.size() != 1 || components.find(component) == std::string_view::npos)
      return fail("a component x, y or z of the goal " + quote_for_message(text.substr(0, bracket)), component);
    text = std::string(trim(std::string_view(text).substr(0, bracket)));
  }
  Goal goal;
  const std::vector<Goal> goals = list_base_goals();
  const auto base = std::find_if(goals.begin(), goals.end(), [&](const Goal& one) { return base_name(one) == text; });
  if (base == goals.end())
    return fail("a goal (" + join_alternatives(goal_names()) + ")", given, format_nearest_name(text, goal_names()));
  goal = *base;
  if (!component.empty() && goal.kind != GoalKind::force && goal.kind != GoalKind::moment)
    return fail("a goal of force or moment before the component [" + component + "]", text);
  if (!component.empty()) goal.component = static_cast<int>(components.find(component));
  if (of && !goal.is_at_constant_speed)
    return fail("a goal at constant speed (constant-speed-force, -moment or -dynamic) before 'of' coordinates", text);
  for (std::string rest = of.value_or(""); !rest.empty();) {
    const std::optional<std::string> next = cut_off(rest, and_word);
    if (std::find(goal.coordinates.begin(), goal.coordinates.end(), rest) == goal.coordinates.end())
      goal.coordinates.push_back(rest);
    rest = next.value_or("");
  }
  if (about && goal.kind != GoalKind::moment)
    return fail(
        "a goal of moment before 'about' and a point", text,
        goal.kind == GoalKind::dynamic ? "without a shaking force the moment is the same about every point" : "");
  goal.about = about.value_or("");
  return {goal, {}};
}

std::vector<std::string> coordinate_names(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const Coordinate& coordinate : mechanism.coordinates) names.push_back(coordinate.name);
  return names;
}

bool is_ground_point(const Mechanism& mechanism, const std::string& name) {
  const std::optional<model::Landmark> landmark = model::find_landmark(mechanism, name);
  return landmark && locate_landmark(mechanism, *landmark).body == model::ground;
}

}  // namespace

std::optional<double> find_order_number(std::string_view text) {
  const auto read = [](std::string_view digits) -> std::optional<double> {
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() && end == digits.data() + digits.size() ? std::optional(value) : std::nullopt;
  };
  const std::size_t slash = text.find('/');
  const std::optional<double> numerator = read(trim(text.substr(0, slash))),
                              denominator = slash == std::string_view::npos ? std::optional(1.0)
                                                                            : read(trim(text.substr(slash + 1)));
  if (!numerator || !denominator) return std::nullopt;
  const double number = *numerator / *denominator;
  return std::isfinite(number) && number > 0 ? std::optional(number) : std::nullopt;
}

std::string GoalMistake::sentence() const {
  return "expected " + expected + ", found " + found + (hint.empty() ? "" : "; " + hint);
}

bool is_whole(const Goal& goal) {
  return goal.kind != GoalKind::order && !goal.is_at_constant_speed && goal.component < 0 && goal.about.empty();
}

bool requires_zero_momentum(const Goal& goal) {
  return (goal.kind == GoalKind::force || goal.kind == GoalKind::dynamic) && is_whole(goal);
}

bool requires_zero_angular_momentum(const Goal& goal) {
  return (goal.kind == GoalKind::moment || goal.kind == GoalKind::dynamic) && is_whole(goal);
}

std::string goal_name(const Goal& goal) {
  if (goal.kind == GoalKind::order)
    return results::name_of(goal.order.part) + (" " + results::format_order(goal.order.number)) + std::string(of_word) +
           goal.order.quantity + std::string(along_word) + goal.order.trajectory;
  std::string name = base_name(goal);
  if (goal.component >= 0) name += "[" + component_name(goal) + "]";
  if (!goal.coordinates.empty()) name.append(of_word).append(join_coordinates(goal));
  if (!goal.about.empty()) name.append(about_word).append(goal.about);
  return name;
}

const std::vector<std::string>& goal_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Goal& goal : list_base_goals()) result.push_back(base_name(goal));
    return result;
  }();
  return names;
}

std::optional<Goal> find_goal(const std::string& text) { return read_goal(text).goal; }

GoalMistake explain_goal_mistake(const std::string& text) { return read_goal(text).mistake; }

namespace {

/// Quantities of runs that are affine in the masses, of which orders can be required to vanish.
std::optional<GoalMistake> find_order_mistake(const OrderReference& order, const Mechanism& mechanism) {
  const std::optional<dynamics::AffineQuantity> quantity = dynamics::find_affine_quantity(mechanism, order.quantity);
  if (!quantity) {
    std::vector<std::string> names = results::list_metric_names(mechanism);
    std::erase_if(names, [&](const std::string& name) { return !dynamics::find_affine_quantity(mechanism, name); });
    std::string mistake;
    const bool is_known = results::describe_quantity(mechanism, order.quantity, mistake).has_value();
    return GoalMistake{
        "a quantity that is linear in the masses (" + join_alternatives(names) + ")", quote_for_message(order.quantity),
        is_known ? "its orders are no linear function of them" : format_nearest_name(order.quantity, names)};
  }
  const bool is_plane_vector = mechanism.space == SpaceKind::planar && !quantity->component && quantity->is_force();
  if (order.part == results::OrderPart::whole || is_plane_vector) return std::nullopt;
  return GoalMistake{
      "a force in the plane, without a component, after '" + std::string(results::name_of(order.part)) + "'",
      quote_for_message(order.quantity), ""};
}

}  // namespace

std::optional<GoalMistake> find_motion_mistake(const Goal& goal, const std::vector<Trajectory>& trajectories) {
  if (goal.kind != GoalKind::order) return std::nullopt;
  std::vector<std::string> names;
  for (const Trajectory& trajectory : trajectories) names.push_back(trajectory.name);
  const auto place = std::find(names.begin(), names.end(), goal.order.trajectory);
  const std::string quoted = quote_for_message(goal.order.trajectory);
  if (names.empty()) return GoalMistake{"a spec with a trajectory", quoted + " but no motion", ""};
  if (place == names.end())
    return GoalMistake{"a trajectory (" + join_alternatives(names) + ")", quoted,
                       format_nearest_name(goal.order.trajectory, names)};
  const Trajectory& trajectory = trajectories[static_cast<std::size_t>(place - names.begin())];
  const std::string example = "a motion with 'speed' and 'turns', such as {drive: joints, speed: {A: 100}}";
  const auto refuse = [&](const std::string& reason) {
    return GoalMistake{"a periodic motion for the order", quoted, reason};
  };
  if (trajectory.free_motion) return refuse("the motion of its free coordinates depends on the masses");
  if (is_mechanism_dependent(trajectory)) return refuse("it depends on the mechanism; use " + example);
  if (!trajectory.adaptations.empty()) return refuse("counterweights move along it");
  if (trajectory.drive == trajectory::DriveKind::com || trajectory.from.com || trajectory.to.com)
    return refuse("it depends on the masses");
  const bool is_table = std::holds_alternative<trajectory::TablePath>(trajectory.path);
  if (!is_table && trajectory.law.kind != trajectory::MotionLawKind::uniform)
    return refuse("its law is " + std::string(trajectory::law_name(trajectory)) + "; use " + example);
  return std::nullopt;
}

std::vector<Trajectory> select_goal_motions(const std::vector<Goal>& goals,
                                            const std::vector<Trajectory>& trajectories) {
  std::vector<Trajectory> motions;
  std::copy_if(trajectories.begin(), trajectories.end(), std::back_inserter(motions), [&](const Trajectory& one) {
    return std::any_of(goals.begin(), goals.end(), [&](const Goal& goal) {
      return goal.kind == GoalKind::order && goal.order.trajectory == one.name;
    });
  });
  return motions;
}

std::optional<GoalMistake> find_goal_mistake(const Goal& goal, const Mechanism& mechanism) {
  if (goal.kind == GoalKind::order) return find_order_mistake(goal.order, mechanism);
  const bool is_planar = mechanism.space == SpaceKind::planar;
  if (is_planar && goal.component >= 0 && goal.kind == GoalKind::moment)
    return GoalMistake{"no component, because the moment in the plane is a number", quote_for_message(goal_name(goal)),
                       ""};
  if (is_planar && goal.component == 2)
    return GoalMistake{"a component x or y in the plane", quote_for_message(goal_name(goal)), ""};
  const std::vector<std::string> coordinates =
      goal.coordinates.empty() ? std::vector<std::string>() : coordinate_names(mechanism);
  for (const std::string& name : goal.coordinates)
    if (std::find(coordinates.begin(), coordinates.end(), name) == coordinates.end())
      return GoalMistake{"a coordinate (" + join_alternatives(coordinates) + ")", quote_for_message(name),
                         format_nearest_name(name, coordinates)};
  if (goal.about.empty() || is_ground_point(mechanism, goal.about)) return std::nullopt;
  std::vector<std::string> points = model::list_landmarks(mechanism);
  std::erase_if(points, [&](const std::string& name) { return !is_ground_point(mechanism, name); });
  return GoalMistake{"a point of the ground (" + join_alternatives(points) + ")", quote_for_message(goal.about),
                     format_nearest_name(goal.about, points)};
}

std::vector<CoordinateId> list_constant_speed_coordinates(const Goal& goal, const Mechanism& mechanism) {
  if (!goal.is_at_constant_speed) return {};
  if (goal.coordinates.empty()) return mechanism.actuators;
  std::vector<CoordinateId> coordinates;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (std::find(goal.coordinates.begin(), goal.coordinates.end(), mechanism.coordinates[c].name) !=
        goal.coordinates.end())
      coordinates.emplace_back(static_cast<int>(c));
  return coordinates;
}

std::optional<GoalMistake> find_goal_mistake(const std::string& text, const Mechanism& mechanism,
                                             const std::vector<Trajectory>& trajectories) {
  const std::optional<Goal> goal = find_goal(text);
  if (!goal) return explain_goal_mistake(text);
  std::optional<GoalMistake> mistake = find_goal_mistake(*goal, mechanism);
  return mistake ? mistake : find_motion_mistake(*goal, trajectories);
}

std::string join_goal_names(const std::vector<Goal>& goals) {
  std::string text;
  for (const Goal& goal : goals) text += (text.empty() ? "" : ", ") + goal_name(goal);
  return text;
}

namespace {

/// "the frame feels no shaking force along y while A is at constant speed: the linear momentum along y is constant"
std::string describe_momentum_goal(const Goal& goal) {
  const std::string axis = component_name(goal), along = axis.empty() ? "" : " along " + axis;
  const std::string about = (axis.empty() ? "" : " about " + axis) +
                            (goal.about.empty() ? "" : (axis.empty() ? " about " : " through ") + goal.about);
  std::string meaning, momentum;
  if (goal.kind == GoalKind::force) {
    meaning = "the frame feels no shaking force" + along;
    momentum = "the linear momentum" + along + " is";
    if (!goal.is_at_constant_speed)
      return meaning + (axis.empty() ? ": the centre of mass stands still" : ": " + momentum + " always zero");
  } else if (goal.kind == GoalKind::moment) {
    meaning = "the frame feels no shaking moment" + about;
    momentum = "the angular momentum" + about + " is";
    if (!goal.is_at_constant_speed) return meaning + ": " + momentum + " always zero";
  } else {
    meaning = "the frame feels neither shaking force nor shaking moment";
    momentum = "both momenta are";
    if (!goal.is_at_constant_speed) return meaning;
  }
  const std::string drives = goal.coordinates.empty()
                                 ? "the drives are"
                                 : join_coordinates(goal) + (goal.coordinates.size() == 1 ? " is" : " are");
  return meaning + " while " + drives + " at constant speed: " + momentum + " constant";
}

}  // namespace

std::string describe_goal(const Goal& goal, const std::string& speeds) {
  const std::string derivatives = "written in the derivatives of " + speeds;
  const auto meaning = [&]() -> std::string {
    switch (goal.kind) {
      case GoalKind::statics: return "at rest the actuators carry nothing";
      case GoalKind::gyroscopic:
        return "the actuators carry nothing at rest and feel no velocity terms, " +
               (speeds.empty() ? "written in the accelerations of all tree coordinates" : derivatives);
      case GoalKind::gyroscopic_independent:
        return "the actuators carry nothing at rest and feel no velocity terms, written in their own accelerations";
      case GoalKind::decoupled:
        if (speeds.empty())
          return "the actuators carry nothing at rest, feel no velocity terms and no acceleration but their own";
        return "the actuators carry nothing at rest and feel neither velocity terms nor a derivative of a speed "
               "but that in their own place, " +
               derivatives;
      case GoalKind::force:
      case GoalKind::moment:
      case GoalKind::dynamic: return describe_momentum_goal(goal);
      case GoalKind::proportional:
        return "the centre of mass follows the tool: its velocity is a constant matrix times the tool's";
      case GoalKind::order:
        return "along " + goal.order.trajectory + " " + goal.order.quantity + " has no " +
               (results::name_of(goal.order.part) + (" " + results::format_order(goal.order.number)));
      case GoalKind::affine:
        return "the centre of mass follows the tool's body: it is a constant matrix times the tool's place, plus "
               "another times the body's rotation, plus a constant";
    }
    return "";
  };
  return meaning() + (goal.is_fully ? ", and feel the same inertia everywhere" : "");
}

}  // namespace balance::study
