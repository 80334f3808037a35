#include "balance/spec/goals.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

std::vector<Goal> read_goals(const SpecCursor& at) {
  std::vector<Goal> goals;
  const auto read_one = [&](const SpecCursor& c) {
    const Goal goal = *find_goal(goal_names()[c.read_choice("a goal", goal_names())]);
    if (std::find(goals.begin(), goals.end(), goal) != goals.end())
      c.fail({.expected = "every goal once", .found = fmt::format("{} again", c.describe_found())});
    goals.push_back(goal);
  };
  if (!at.is_list()) {
    read_one(at);
    return goals;
  }
  for (const SpecCursor& item : at.items("a list of goals")) at.problems().collect([&] { read_one(item); });
  if (at.node().items.empty()) at.fail_expected("at least one goal");
  return goals;
}

}  // namespace balance::specification
