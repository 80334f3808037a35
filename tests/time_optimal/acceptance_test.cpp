// Durations and peaks of laws for the specs in configs/, each known from a second program to the digits given.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::time_optimal;

namespace {

/// What the guided centre of mass of the 3RRR needs for 0.1 s (P3) [N].
constexpr double guided = 549.2528818391;

/// Of the references.
constexpr double digits = 1e-9;

struct Case {
  Mechanism mechanism;
  Trajectory trajectory;
};

Case take(const std::string& config, DriveKind drive, const std::vector<trajectory::MotionLimit>& limits) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config);
  const auto cycloid = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                                    [](const Trajectory& t) { return t.name == "cycloid"; });
  REQUIRE(cycloid != study.trajectories.end());
  Case result{study.mechanism, *cycloid};
  result.trajectory.law.kind = MotionLawKind::time_optimal;
  result.trajectory.drive = drive;
  result.trajectory.limits = limits;
  result.trajectory.samples = 2001;
  return result;
}

Case gentle(const std::string& config, const std::string& quantity, double duration) {
  Case result = take(config, DriveKind::tool, {});
  result.trajectory.law.kind = MotionLawKind::min_peak;
  result.trajectory.min_peak_quantity = quantity;
  result.trajectory.duration = duration;
  return result;
}

double peak(const RunResult& result, const std::string& quantity) {
  for (const Metric& metric : result.metrics)
    if (metric.quantity == quantity) return metric.peak;
  FAIL("no figure of " << quantity);
  return 0;
}

/// Simulates by both formulations what was found, and checks that limits are kept, one of them fully used.
void check_limits(const Case& c, const Trajectory& found, const std::vector<trajectory::MotionLimit>& limits) {
  for (const RunResult& run : {simulate(c.mechanism, found), verification::simulate_natural(c.mechanism, found)}) {
    INFO(run.outcome.reason);
    REQUIRE(run.outcome.status == MotionStatus::done);
    double fullest = 0;
    for (const trajectory::MotionLimit& limit : limits) {
      const double used = peak(run, limit.quantity) / limit.upper_bound;
      CAPTURE(limit.quantity);
      CHECK(used < 1 + 1e-5);
      fullest = std::max(fullest, used);
    }
    CHECK(fullest > 1 - 1e-5);
  }
}

void check_fastest(const Case& c, double duration, double tolerance = digits) {
  const ResolvedTrajectory timed = resolve_trajectory(c.mechanism, c.trajectory);
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  CHECK(timed.trajectory.duration == doctest::Approx(duration).epsilon(tolerance));
  check_limits(c, timed.trajectory, c.trajectory.limits);
}

/// @param digit one in the value's last digit, which is not sure
void check_gentlest(const Case& c, double value, double digit) {
  const ResolvedTrajectory timed = resolve_trajectory(c.mechanism, c.trajectory);
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  CHECK(std::abs(timed.optimised_law->objective_value - value) <= digit);
  CHECK(timed.trajectory.duration == c.trajectory.duration);
  check_limits(c, timed.trajectory, {{c.trajectory.min_peak_quantity, value}});
}

}  // namespace

TEST_CASE("the 3RRR's tool on its line within what the guided centre of mass asks of the frame") {
  check_fastest(take("3rrr.yaml", DriveKind::tool, {{"shaking_force", guided}}), 0.100625514047);
  check_fastest(take("3rrr.yaml", DriveKind::tool, {{"shaking_force", guided}, {"torque", 80}}), 0.100625514047);
}

TEST_CASE("the 3RRR under limits of force and moment") {
  check_fastest(take("3rrr.yaml", DriveKind::tool, {{"shaking_force", guided}, {"shaking_moment", 30}}), 0.1044812645);
}

TEST_CASE("the 3RRR under limits of torque") {
  check_fastest(take("3rrr.yaml", DriveKind::tool, {{"torque", 60}}), 0.101440934032);
}

TEST_CASE("the 3RRR under a limit of the moment alone, which has places without inertia") {
  check_fastest(take("3rrr.yaml", DriveKind::tool, {{"shaking_moment", 30}}), 0.0887504790);
}

TEST_CASE("P3's bang-bang law of the centre of mass is the fastest under its force") {
  check_fastest(take("3rrr.yaml", DriveKind::com, {{"shaking_force", guided}}), 0.1);
}

TEST_CASE("arms with weight under limits of torque") {
  check_fastest(take("5r.yaml", DriveKind::tool, {{"torque", 12}}), 0.301490853880);
  check_fastest(take("rr.yaml", DriveKind::tool, {{"torque[R1]", 40}, {"torque[R2]", 10}}), 0.382081023152);
}

TEST_CASE("the gentlest motions of the 3RRR") {
  check_gentlest(gentle("3rrr.yaml", "shaking_force", 0.1), 556.145680, 1e-6);
  check_gentlest(gentle("3rrr.yaml", "torque", 0.1), 61.741579, 1e-6);
  check_gentlest(gentle("3rrr.yaml", "shaking_moment", 0.1), 23.629943, 1e-6);
}

TEST_CASE("the gentlest motions of the 5R, which carries weight") {
  check_gentlest(gentle("5r.yaml", "torque", 0.5), 8.873157415, 1e-9);
  check_gentlest(gentle("5r.yaml", "torque", 0.4), 9.844587722, 1e-9);
}
