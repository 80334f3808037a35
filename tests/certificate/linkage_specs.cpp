#include "linkage_specs.hpp"

#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/certificate/length_bound.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <vector>

namespace linkage_specs {

std::string read_text(const std::string& name) {
  std::ifstream file(std::string(BALANCE_TEST_DATA) + "/specs/" + name + ".yaml");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string replace_text(std::string text, const std::string& before, const std::string& after) {
  const std::size_t place = text.find(before);
  REQUIRE(place != std::string::npos);
  return text.replace(place, before.size(), after);
}

bool can_move(const balance::DesignSpace& space, const balance::VectorX& x) {
  const balance::study::DesignInstance instance = space.instantiate(x);
  const std::vector<int> followed = balance::certificate::list_followed_trajectories(space);
  return instance.mode_issue.empty() && std::all_of(followed.begin(), followed.end(), [&](int index) {
           const balance::Trajectory& trajectory = instance.trajectories[static_cast<std::size_t>(index)];
           return balance::simulate(instance.mechanism, trajectory).outcome.status == balance::MotionStatus::done;
         });
}

}  // namespace linkage_specs
