/// Both formulations on every planar mechanism and trajectory of configs/.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"

#include <doctest/doctest.h>

#include <filesystem>

using namespace balance;
using namespace balance::verification;

TEST_CASE("both formulations agree to 1e-9 on every trajectory of every planar config, and on its force conditions") {
  int specs = 0, trajectories = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    Study study = read_spec_file(entry.path().string());
    if (study.mechanism.space != SpaceKind::planar) continue;
    if (has_velocity_constraints(study.mechanism)) {
      CHECK_THROWS_AS(verify_formulations(study), std::invalid_argument);
      continue;
    }
    CAPTURE(entry.path().string());
    for (Trajectory& trajectory : study.trajectories) trajectory.samples = 101;
    const VerifyReport report = verify_formulations(study);
    CHECK(report.is_consistent);
    CHECK(report.conditions.reason.empty());
    CHECK(report.conditions.subspace_angle_sine < 1e-12);
    for (const TrajectoryVerification& run : report.trajectories) {
      CAPTURE(run.trajectory);
      CHECK_MESSAGE(run.natural.status == MotionStatus::done, run.natural.reason);
      for (const QuantityDifference& difference : run.differences) {
        CAPTURE(difference.quantity);
        CHECK(difference.relative() <= 1e-9);
      }
      ++trajectories;
    }
    ++specs;
  }
  CHECK(specs >= 29);
  CHECK(trajectories >= 70);
}
