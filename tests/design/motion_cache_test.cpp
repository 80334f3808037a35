// What depends only on a motion is computed once for all designs and figures that share it.

#include "balance/synthesis/design/motion_cache.hpp"

#include "balance/interface/specification/read_spec.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace balance;
using namespace balance::design;

namespace {

Study four_bar() { return read_spec_file(BALANCE_CONFIGS "/four-bar.yaml"); }

}  // namespace

TEST_CASE("mechanisms that differ only in masses share the rows of their motion, those with other lengths do not") {
  const Study study = four_bar();
  const Trajectory& trajectory = study.trajectories.front();
  Mechanism heavier = study.mechanism, longer = study.mechanism;
  for (Body& body : heavier.bodies) body.mass *= 2, body.com *= 0.5;
  for (auto& point : longer.bodies.back().points) point.position *= 1.01;
  for (Joint& joint : longer.joints) joint.point_second *= 1.01;
  MotionCache cache;
  const auto rows = cache.rows(study.mechanism, trajectory, {}, "shaking_force");
  REQUIRE(rows);
  CHECK(cache.rows(heavier, trajectory, {}, "shaking_force") == rows);
  CHECK(cache.rows(longer, trajectory, {}, "shaking_force") != rows);
  CHECK(cache.rows(study.mechanism, trajectory, {}, "shaking_force") == rows);
}

TEST_CASE("rows of several quantities from one pass are those of a pass for each") {
  const Study study = four_bar();
  const Trajectory& trajectory = study.trajectories.front();
  const std::vector<std::string> quantities = {"shaking_force", "torque", "shaking_moment", "kinetic_energy",
                                               "no such quantity"};
  const TrajectoryCost cost(study.mechanism, trajectory);
  const auto together = cost.rows(quantities);
  REQUIRE(together.size() == quantities.size());
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    CAPTURE(quantities[q]);
    const auto alone = cost.rows({quantities[q]}).front();
    REQUIRE(alone.has_value() == together[q].has_value());
    CHECK(alone.has_value() == (quantities[q] != "no such quantity"));
    if (!alone) continue;
    REQUIRE(alone->size() == together[q]->size());
    for (std::size_t s = 0; s < alone->size(); ++s) {
      CHECK((*alone)[s].rows == (*together[q])[s].rows);
      CHECK((*alone)[s].time_weights == (*together[q])[s].time_weights);
      CHECK((*alone)[s].time_weights.sum() == doctest::Approx(1).epsilon(1e-12));  // round-off of the sum
    }
  }
}
