/// What no law says but two independent formulations must agree on: everything, for mechanisms that nobody designed.

#include "random_mechanisms.hpp"

#include "balance/synthesis/verification/formulation_check.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace laws;

TEST_CASE("both formulations agree on random planar mechanisms, in motion and on the conditions for a force balance") {
  int runs = 0, drives[3] = {0, 0, 0};
  for (std::uint32_t seed = 1; seed <= 120; ++seed) {
    const auto experiment = random_experiment(SpaceKind::planar, seed);
    if (!experiment) continue;
    CAPTURE(seed);
    const verification::TrajectoryVerification moved =
        verification::verify_trajectory(experiment->mechanism, experiment->trajectory);
    CHECK(moved.tree.status == MotionStatus::done);
    CHECK_MESSAGE(moved.natural.status == MotionStatus::done, moved.natural.reason);
    for (const verification::QuantityDifference& difference : moved.differences) {
      CAPTURE(difference.quantity);
      CHECK(difference.relative() <= 1e-9);  // none comes nearer to a singularity than a mobility of 0.02
    }
    Study study;
    study.mechanism = experiment->mechanism;
    study.trajectories = {experiment->trajectory};
    const verification::ConditionsVerification conditions = verification::verify_conditions(study);
    CHECK(conditions.reason.empty());
    CHECK(conditions.sampled == conditions.coefficients);
    CHECK(conditions.subspace_angle_sine < 1e-9);
    ++runs;
    ++drives[static_cast<int>(experiment->trajectory.drive)];
  }
  CHECK(runs > 100);
  for (const int count : drives) CHECK(count > 5);
}
