#include "balance/spec/goals.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

std::vector<Goal> read_goals(const Cursor& at) {
  std::vector<Goal> goals;
  const auto read_one = [&](const Cursor& c) {
    const Goal goal = *find_goal(goal_names()[c.choice("a goal", goal_names())]);
    if (std::find(goals.begin(), goals.end(), goal) != goals.end())
      c.fail({.expected = "every goal once", .found = fmt::format("{} again", c.found())});
    goals.push_back(goal);
  };
  if (!at.is_list()) {
    read_one(at);
    return goals;
  }
  for (const Cursor& item : at.items("a list of goals")) at.problems().guard([&] { read_one(item); });
  if (at.node().items.empty()) at.expected("at least one goal");
  return goals;
}

}  // namespace balance::read
