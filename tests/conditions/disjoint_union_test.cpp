// Several mechanisms as one.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <doctest/doctest.h>

#include <filesystem>

using namespace balance;

namespace {

Mechanism renamed(Mechanism mechanism) {
  const auto add_suffix = [](auto& all, std::size_t first) {
    for (std::size_t i = first; i < all.size(); ++i) all[i].name += "'";
  };
  add_suffix(mechanism.bodies, 1);
  add_suffix(mechanism.joints, 0);
  add_suffix(mechanism.constraints, 0);
  add_suffix(mechanism.attachments, 0);
  add_suffix(mechanism.discs, 0);
  add_suffix(mechanism.loads, 0);
  add_suffix(mechanism.springs, 0);
  mechanism.coordinates = list_coordinates(mechanism.space, mechanism.joints);
  return mechanism;
}

}  // namespace

TEST_CASE("two mechanisms side by side have the freedoms and the force conditions of both, for every config") {
  int specs = 0, constrained = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    CAPTURE(entry.path().string());
    const Mechanism one = read_spec_file(entry.path().string()).mechanism,
                    two = model::disjoint_union({one, renamed(one)});
    REQUIRE(validate(two).empty());
    for (const std::size_t k : {0, 1}) {
      const Mechanism part = model::extract_part(two, one, k);
      CHECK(dynamics::parameter_values(part) == dynamics::parameter_values(one));
      CHECK(part.actuators == one.actuators);
      for (std::size_t j = 0; j < one.joints.size(); ++j)
        CHECK((part.joints[j].first == one.joints[j].first && part.joints[j].second == one.joints[j].second));
      if (one.tool) CHECK(part.tool->position == one.tool->position);
    }
    Study single_study, double_study;
    single_study.mechanism = one, double_study.mechanism = two;
    CHECK(check_mechanism(double_study).degrees_of_freedom == 2 * check_mechanism(single_study).degrees_of_freedom);
    if (one.coordinates.size() > 12) continue;
    const Conditions single = derive_conditions(one, {{GoalKind::force, false}}),
                     both = derive_conditions(two, {{GoalKind::force, false}});
    REQUIRE(single.status == both.status);
    // the force of both vanishes where each one's does, or where they cancel, which independent motions cannot
    CHECK(both.rank == 2 * single.rank);
    ++specs;
    constrained += has_velocity_constraints(one) ? 1 : 0;
  }
  CHECK(specs >= 20);
  CHECK(constrained >= 2);
}
