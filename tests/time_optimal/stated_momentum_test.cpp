// A stated angular momentum as a drive, against the momentum of the run by another way and against the natural formulation.

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

using namespace balance;

namespace {

Study study_with(const std::string& config, const std::string& trajectories) {
  std::ifstream file(std::string(BALANCE_CONFIGS) + "/" + config);
  std::stringstream all;
  all << file.rdbuf();
  std::string text = all.str();
  return read_spec(text.substr(0, text.find("\ntrajectories:")) + "\ntrajectories:\n" + trajectories, config);
}

/// The platform so heavy that its turning always counts.
Study heavy(const std::string& trajectories) {
  Study study = study_with("3rrr.yaml", trajectories);
  for (Body& body : study.mechanism.bodies)
    if (body.name == "platform") body.inertia(2, 2) = 0.02;
  return study;
}

/// Angular momentum of a sample: the moment that would give the resting mechanism its rates as accelerations.
Vector3 momentum_at(InverseDynamics& dynamics, const RunResult& run, Eigen::Index row) {
  const auto n = static_cast<Eigen::Index>(dynamics.independent().size());
  VectorX q(n), dq(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& names = run.coordinate_names;
    const auto name = std::find(names.begin(), names.end(), dynamics.independent()[static_cast<std::size_t>(i)]);
    q[i] = run.joint_position(row, name - names.begin());
    dq[i] = run.joint_velocity(row, name - names.begin());
  }
  const Expected<Sample> seen = dynamics.at(q, VectorX::Zero(n), dq);
  REQUIRE(seen);
  return seen.value.shaking_moment;
}

RunResult done(const Study& study, std::size_t trajectory = 0) {
  const RunResult run = simulate(study.mechanism, study.trajectories[trajectory]);
  INFO(run.outcome.reason);
  REQUIRE(run.outcome.status == MotionStatus::done);
  return run;
}

}  // namespace

TEST_CASE("a constant angular momentum is kept, whatever the law, and there is no shaking moment") {
  const Study study = heavy(
      "  up: {law: bang-bang, drive: com, samples: 201, remaining: {angle: {momentum: 0.05}}}\n"
      "  down: {law: cycloidal, drive: com, samples: 201, remaining: {angle: {momentum: -0.03}}}\n"
      "  plain: {law: bang-bang, drive: com, samples: 201}\n");
  const double usual = done(study, 2).shaking_moment.cwiseAbs().maxCoeff();
  for (const auto& [index, stated] : {std::pair<std::size_t, double>{0, 0.05}, {1, -0.03}}) {
    const RunResult run = done(study, index);
    InverseDynamics dynamics(study.mechanism);
    for (Eigen::Index row = 0; row < run.time.size(); row += 10)
      CHECK(std::abs(momentum_at(dynamics, run, row).z() - stated) < 1e-8 * std::abs(stated));
    CHECK(run.shaking_moment.cwiseAbs().maxCoeff() < 1e-8 * usual);
    const RunResult natural = verification::simulate_natural(study.mechanism, study.trajectories[index]);
    REQUIRE(natural.outcome.status == MotionStatus::done);
    CHECK(natural.shaking_moment.cwiseAbs().maxCoeff() < 1e-8 * usual);
  }
}

TEST_CASE("a table of the angular momentum is followed, and its slope is the shaking moment") {
  const Study study = heavy(
      "  along: {law: 3-4-5, drive: com, samples: 401, remaining: {angle: {momentum:\n"
      "    {table: [[0, 0], [0.03, 0.02], [0.05, 0.01], [0.08, 0.03], [0.1, 0]]}}}}\n");
  const VectorX values = (VectorX(5) << 0, 0.02, 0.01, 0.03, 0).finished();
  const numerics::CubicSpline stated({0, 0.03, 0.05, 0.08, 0.1}, Samples(values), numerics::SplineEnd::not_a_knot);
  const RunResult run = done(study), natural = verification::simulate_natural(study.mechanism, study.trajectories[0]);
  REQUIRE(natural.outcome.status == MotionStatus::done);
  InverseDynamics dynamics(study.mechanism);
  const double most = 0.03, steepest = run.shaking_moment.cwiseAbs().maxCoeff();
  VectorX value(1), first(1), second(1);
  for (Eigen::Index row = 0; row < run.time.size(); row += 8) {
    stated.at(run.time[row], value, first, second);
    CAPTURE(run.time[row]);
    CHECK(std::abs(momentum_at(dynamics, run, row).z() - value[0]) < 1e-8 * most);
    CHECK(std::abs(run.shaking_moment(row, 0) - first[0]) < 1e-7 * steepest);
    CHECK(std::abs(natural.shaking_moment(row, 0) - first[0]) < 1e-7 * steepest);
  }
}

TEST_CASE("in space every quantity keeps a component of its own") {
  const Study study =
      study_with("spatial-rrr.yaml",
                 "  two: {law: cycloidal, drive: tool, components: [x], samples: 101, from: {joints: {J1: -0.5, "
                 "J2: 0.3, J3: -0.6}}, to: {tool: [0.25, 0.4, 0.5]}, remaining: {J2: {momentum: 0.05, axis: x}, "
                 "J1: {momentum: {table: [[0, 0], [0.4, 0.01], [1, 0.04]]}, axis: z}}}\n");
  const RunResult run = done(study);
  const VectorX values = (VectorX(3) << 0, 0.01, 0.04).finished();
  const numerics::CubicSpline stated({0, 0.4, 1}, Samples(values), numerics::SplineEnd::natural);
  InverseDynamics dynamics(study.mechanism);
  VectorX value(1), first(1), second(1);
  for (Eigen::Index row = 0; row < run.time.size(); row += 5) {
    stated.at(run.time[row], value, first, second);
    const Vector3 momentum = momentum_at(dynamics, run, row);
    CHECK(std::abs(momentum.x() - 0.05) < 1e-8 * 0.05);
    CHECK(std::abs(momentum.z() - value[0]) < 1e-8 * 0.05);
  }
}

TEST_CASE("a spline over the time beside a kept momentum goes by the law's own time") {
  const Study study =
      study_with("planar-rrr.yaml",
                 "  still: {law: bang-bang, drive: tool, components: [x], samples: 201, from: {joints: {J1: 0.3, J2: "
                 "0.8, J3: 0.4}}, "
                 "to: {tool: [0.3, 0.4]}, remaining: {J2: {spline: [0.2, -0.3, 0.1]}, J3: {momentum: zero}}}\n");
  const RunResult run = done(study);
  InverseDynamics dynamics(study.mechanism);
  for (Eigen::Index row = 0; row < run.time.size(); row += 20)
    CHECK(std::abs(momentum_at(dynamics, run, row).z()) < 1e-10);
}

TEST_CASE("a momentum that cannot be kept, or is not stated to the end, is refused with the place") {
  const Study light =
      study_with("3rrr.yaml", "  up: {law: bang-bang, drive: com, remaining: {angle: {momentum: 0.01}}}\n");
  const RunResult lost = simulate(light.mechanism, light.trajectories.front());
  CHECK(lost.outcome.status == MotionStatus::drive_singularity);
  CHECK(lost.outcome.reason.starts_with("at t = "));
  CHECK(lost.outcome.reason.find("% of the path") != std::string::npos);
  const Study brief =
      heavy("  short: {law: bang-bang, drive: com, remaining: {angle: {momentum: {table: [[0, 0], [0.05, 0.01]]}}}}\n");
  const RunResult gap = simulate(brief.mechanism, brief.trajectories.front());
  CHECK(gap.outcome.reason ==
        "the angular momentum is stated from 0 s to 0.05 s, but the motion lasts from 0 to 0.1 s");
}
