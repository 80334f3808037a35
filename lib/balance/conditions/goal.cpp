#include "balance/conditions/goal.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace balance {

namespace {

using namespace std::string_view_literals;

constexpr std::array plain = {
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

/// P0 defines the adjective for what the actuators feel.
bool may_be_full(GoalKind kind) { return kind <= GoalKind::decoupled; }

}  // namespace

std::string name_of(const Goal& goal) {
  const auto at = std::find_if(plain.begin(), plain.end(), [&](const auto& p) { return p.first == goal.kind; });
  return (goal.fully ? "fully-" : "") + std::string(at->second);
}

const std::vector<std::string>& goal_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const bool fully : {false, true})
      for (const auto& [kind, name] : plain)
        if (!fully || may_be_full(kind)) all.push_back(name_of({kind, fully}));
    return all;
  }();
  return names;
}

std::optional<Goal> find_goal(const std::string& name) {
  for (const bool fully : {false, true})
    for (const auto& [kind, plain_name] : plain)
      if ((!fully || may_be_full(kind)) && name == name_of({kind, fully})) return Goal{kind, fully};
  return std::nullopt;
}

}  // namespace balance
