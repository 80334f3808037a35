#include "balance/motion/study/balance_goal.hpp"

#include <algorithm>
#include <array>
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

/// P0 defines "fully" for goals of the actuators only.
bool can_be_fully(GoalKind kind) { return kind <= GoalKind::decoupled; }

}  // namespace

std::string goal_name(const Goal& goal) {
  const auto entry =
      std::find_if(base_goal_names.begin(), base_goal_names.end(), [&](const auto& p) { return p.first == goal.kind; });
  return (goal.is_fully ? "fully-" : "") + std::string(entry->second);
}

const std::vector<std::string>& goal_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const bool fully : {false, true})
      for (const auto& [kind, name] : base_goal_names)
        if (!fully || can_be_fully(kind)) result.push_back(goal_name({kind, fully}));
    return result;
  }();
  return names;
}

std::optional<Goal> find_goal(const std::string& name) {
  for (const bool fully : {false, true})
    for (const auto& [kind, plain_name] : base_goal_names)
      if ((!fully || can_be_fully(kind)) && name == goal_name({kind, fully})) return Goal{kind, fully};
  return std::nullopt;
}

std::string join_goal_names(const std::vector<Goal>& goals) {
  std::string text;
  for (const Goal& goal : goals) text += (text.empty() ? "" : ", ") + goal_name(goal);
  return text;
}

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
      case GoalKind::force: return "the frame feels no shaking force: the centre of mass stands still";
      case GoalKind::moment: return "the frame feels no shaking moment: the angular momentum is always zero";
      case GoalKind::dynamic: return "the frame feels neither shaking force nor shaking moment";
      case GoalKind::proportional:
        return "the centre of mass follows the tool: its velocity is a constant matrix times the tool's";
      case GoalKind::affine:
        return "the centre of mass follows the tool's body: it is a constant matrix times the tool's place, plus "
               "another times the body's rotation, plus a constant";
    }
    return "";
  };
  return meaning() + (goal.is_fully ? ", and feel the same inertia everywhere" : "");
}

}  // namespace balance::study
