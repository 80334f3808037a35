// Limits that differ by sign, and the plane of place and rate in which limits and laws meet.

#include "slider.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace intervals_test {

using namespace balance;
using namespace balance::time_optimal;

namespace {

constexpr double distance = 0.6, mass = 2;

Trajectory named(const Study& study, const std::string& name) {
  const auto found = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                                  [&](const Trajectory& t) { return t.name == name; });
  REQUIRE(found != study.trajectories.end());
  return *found;
}

/// The ceiling at a place, between those next to it.
double ceiling_at(const trajectory::PhasePlane& plane, double place) {
  Eigen::Index k = 1;
  while (k + 1 < plane.mvc_path_parameter.size() && plane.mvc_path_parameter[k] < place) ++k;
  return std::max(plane.mvc_path_rate[k - 1], plane.mvc_path_rate[k]);
}

}  // namespace

TEST_CASE("a force that may push more than it may pull drives by its own closed form") {
  const double push = 12, pull = 5, g = 1.5;
  const Mechanism slider = make_slider({.mass = mass, .gravity = g});
  const double a = push / mass - g, b = pull / mass + g;
  const ResolvedTrajectory timed = resolve_trajectory(slider, slide(distance, {{"force[D]", push, -pull}}));
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  CHECK(timed.trajectory.duration == doctest::Approx(std::sqrt(2 * distance * (1 / a + 1 / b))).epsilon(1e-9));
}

TEST_CASE("an interval about zero is the limit of the magnitude") {
  const Mechanism slider = make_slider({.mass = mass, .gravity = 2, .viscous = 3});
  const double symmetric = resolve_trajectory(slider, slide(distance, {{"torque", 15}})).trajectory.duration;
  const double interval = resolve_trajectory(slider, slide(distance, {{"torque", 15, -15.0}})).trajectory.duration;
  CHECK(interval == symmetric);
}

TEST_CASE("an interval that rest breaks is refused with what it needs") {
  const Mechanism slider = make_slider({.mass = mass, .gravity = 2});  // 4 N hold it
  const ResolvedTrajectory timed = resolve_trajectory(slider, slide(distance, {{"torque", 12, 5.0}}));
  CHECK(timed.outcome.reason.ends_with("% of the path force[D] needs 4 N at rest, 1 N less than its limit"));
  CHECK_THROWS_AS(resolve_trajectory(slider, slide(distance, {{"torque", 5, 5.0}})), std::invalid_argument);
}

TEST_CASE("torques of the 3RRR between limits that differ by sign use both of them and nothing beyond") {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/3rrr.yaml");
  Trajectory trajectory = named(study, "tool-bang");
  trajectory.law.kind = MotionLawKind::time_optimal;
  trajectory.limits = {{"torque", 70, -50.0}};
  const RunResult run = simulate(study.mechanism, trajectory);
  INFO(run.outcome.reason);
  REQUIRE(run.outcome.status == MotionStatus::done);
  CHECK(run.torque.maxCoeff() < 70 * (1 + 1e-5));
  CHECK(run.torque.minCoeff() > -50 * (1 + 1e-5));
  for (Eigen::Index row = 2; row + 2 < run.time.size(); ++row)  // somewhere always one of them holds it back
    CHECK(std::max(run.torque.row(row).maxCoeff() / 70, -run.torque.row(row).minCoeff() / 50) > 1 - 1e-5);
}

TEST_CASE("the ceiling of a limited speed is that speed, and the law touches it") {
  const double most = 0.9;
  const RunResult run =
      simulate(make_slider({.mass = mass}), slide(distance, {{"torque", 30}, {"joint_velocity", most}}));
  REQUIRE(run.outcome.status == MotionStatus::done);
  const trajectory::PhasePlane& plane = run.phase_plane;
  REQUIRE(plane.mvc_path_rate.size() > 10);
  CHECK((plane.mvc_path_rate.array() - most / distance).abs().maxCoeff() < 1e-9 * most / distance);
  CHECK(plane.path_rate.maxCoeff() == doctest::Approx(most / distance).epsilon(1e-9));
}

TEST_CASE("a law stays below its ceiling, and its way over its rate is its duration") {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/3rrr.yaml");
  for (const MotionLawKind law : {MotionLawKind::time_optimal, MotionLawKind::min_peak, MotionLawKind::cycloidal}) {
    Trajectory trajectory = named(study, "cycloid");
    trajectory.law.kind = law;
    trajectory.limits = {{"torque", law == MotionLawKind::cycloidal ? 120.0 : 80.0}};
    if (law == MotionLawKind::min_peak) trajectory.min_peak_quantity = "shaking_force", trajectory.limits.clear();
    const RunResult run = simulate(study.mechanism, trajectory);
    REQUIRE(run.outcome.status == MotionStatus::done);
    const trajectory::PhasePlane& plane = run.phase_plane;
    CHECK(plane.path_parameter[0] == 0);
    CHECK(plane.path_parameter[plane.path_parameter.size() - 1] == doctest::Approx(1).epsilon(1e-12));
    double way = 0;  // trapezoids of the rate over the time
    for (Eigen::Index k = 1; k < plane.time.size(); ++k) {
      way += (plane.path_rate[k] + plane.path_rate[k - 1]) / 2 * (plane.time[k] - plane.time[k - 1]);
      CHECK(plane.path_rate[k] <= ceiling_at(plane, plane.path_parameter[k]) * (1 + 1e-6));
    }
    CHECK(way == doctest::Approx(1).epsilon(1e-4));
  }
}

TEST_CASE("limits beside a law that does not ask for them change nothing") {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/5r.yaml");
  Trajectory trajectory = named(study, "cycloid");
  const RunResult plain = simulate(study.mechanism, trajectory);
  trajectory.limits = {{"torque", 10}};
  const RunResult observed = simulate(study.mechanism, trajectory);
  CHECK(plain.torque == observed.torque);
  CHECK(plain.phase_plane.mvc_path_rate.size() == 0);
  CHECK(observed.phase_plane.mvc_path_rate.size() > 100);
  CHECK(plain.phase_plane.path_rate == observed.phase_plane.path_rate);
  CHECK_FALSE(observed.optimised_law.has_value());
}

TEST_CASE("a path of spherical joints, whose axes turn on the way, is looked at as often as it takes") {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/stewart.yaml");
  Trajectory trajectory = named(study, "legs");
  trajectory.law.kind = MotionLawKind::time_optimal;
  trajectory.limits = {{"shaking_moment_com", 14.9}, {"shaking_force", 22.96}};
  trajectory.samples = 201;
  const RunResult run = simulate(study.mechanism, trajectory);
  INFO(run.outcome.reason);
  REQUIRE(run.outcome.status == MotionStatus::done);
  for (Eigen::Index row = 0; row < run.time.size(); ++row) {
    CHECK(run.shaking_moment_com.row(row).norm() < 14.9 * (1 + 1e-5));
    CHECK(run.shaking_force.row(row).norm() < 22.96 * (1 + 1e-5));
  }
}

}  // namespace intervals_test
