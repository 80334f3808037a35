// Numbers that over-constrained loops cannot follow.

#include "numbers.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <random>
#include <string>

namespace openings_test {

using namespace balance;
using namespace balance::derivatives;

namespace {

constexpr double step = 1e-4;  // of a number's size

}  // namespace

TEST_CASE("a number opens a joint if, and only if, the mechanism cannot be assembled with the number moved") {
  std::mt19937 random(3);
  int opening = 0, following = 0;
  for (const char* name : {"four-bar-in-space.yaml", "bricard.yaml", "delta.yaml", "slider-crank.yaml"}) {
    const Study study = read_spec_file(std::string(BALANCE_CONFIGS "/") + name);
    Trajectory trajectory = study.trajectories.at(0);
    trajectory.samples = 5;
    for (int round = 0; round < 4; ++round) {
      const auto numbers = gradients::some_numbers(study.mechanism, numerics::dual_width, random);
      MechanismOf<DualNumber> duals = to_dual(study.mechanism);
      for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k].in_duals(duals).d[k] += 1;
      const RunGradient gradient = differentiate_run(duals, to_dual(trajectory), {"torque"});
      REQUIRE(gradient.run.outcome.status == MotionStatus::done);
      for (std::size_t k = 0; k < numbers.size(); ++k) {
        Mechanism moved = study.mechanism;
        numbers[k].in(moved) += step * numbers[k].scale;
        const bool runs = simulate(moved, trajectory).outcome.status == MotionStatus::done;
        CHECK_MESSAGE(gradient.closure_gaps[k].empty() == runs, std::string(name) << ": " << numbers[k].name);
        ++(runs ? following : opening);
      }
    }
  }
  CHECK(opening > 3);
  CHECK(following > 20);
}

TEST_CASE("a joint opens by what is moved across the plane that its loop stays in") {
  const Study study = read_spec_file(BALANCE_CONFIGS "/four-bar-in-space.yaml");
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 5;
  MechanismOf<DualNumber> duals = to_dual(study.mechanism);
  duals.joints[0].point_first[0].d[0] = 1;
  duals.joints[0].point_first[2].d[1] = 1;
  const RunGradient gradient = differentiate_run(duals, to_dual(trajectory), {"torque"});
  CHECK(gradient.closure_gaps[0].empty());
  REQUIRE(gradient.closure_gaps[1].size() == 1);
  CHECK(gradient.closure_gaps[1][0].is_length);
  CHECK(gradient.closure_gaps[1][0].gap == doctest::Approx(1).epsilon(1e-9));  // nothing else can take it up
}

}  // namespace openings_test
