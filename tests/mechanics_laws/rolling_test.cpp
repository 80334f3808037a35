// Where rates are bound: what the motors do in inverse dynamics gives the same accelerations, reactions and ways in forward dynamics.

#include "../dynamics/every_config.hpp"

#include "balance/motion/control/plant.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

namespace rolling_test {

using namespace balance;

namespace {

constexpr const char* machines[] = {"rolling-cart.yaml", "rolling-on-a-plane.yaml", "sleigh.yaml"};

double largest(const Eigen::Ref<const VectorX>& values) { return values.cwiseAbs().maxCoeff(); }

/// A skate in space: the tool of an arm with three joints must not slip across its own axis, and turns with its first joint.
Study skating_arm() {
  Study study = doors::config("spatial-rrr.yaml");
  const Tool& tool = *study.mechanism.tool;
  const auto term = [&](model::GeneralisedSpeedTerm::Kind kind, int index, double factor, BodyId body,
                        const Vector3& position) {
    model::GeneralisedSpeedTerm one;
    one.kind = kind, one.index = index, one.factor = factor, one.body = body, one.position = position;
    return one;
  };
  using Kind = model::GeneralisedSpeedTerm::Kind;
  model::GeneralisedSpeed sum;
  sum.name = "edge";
  sum.terms = {term(Kind::velocity_body, 2, 1, tool.body, tool.position),
               term(Kind::angular_velocity_body, 0, 0.3, tool.body, tool.position),
               term(Kind::angular_velocity, 2, -0.1, tool.body, tool.position),
               term(Kind::coordinate, 1, 0.2, 0, Vector3::Zero())};
  study.mechanism.constraints.push_back(sum);
  study.mechanism.actuators.pop_back();
  Trajectory& motion = study.trajectories.front();
  motion = {};
  motion.name = "skate";
  motion.law.kind = MotionLawKind::cycloidal;
  motion.drive = DriveKind::joints;
  for (const int c : study.mechanism.actuators) {
    motion.from.joints.push_back({c, 0.4});
    motion.to.joints.push_back({c, 1.1});
  }
  return study;
}

void check_ways_agree(const Study& study, const Trajectory& trajectory) {
  CAPTURE(study.mechanism.name);
  CAPTURE(trajectory.name);
  const Mechanism& mechanism = study.mechanism;
  const RunResult run = simulate(mechanism, trajectory);
  REQUIRE_MESSAGE(run.outcome.status == MotionStatus::done, run.outcome.reason);
  control::Plant plant(mechanism);
  const Eigen::Index last = run.time.size() - 1;
  for (const Eigen::Index k : {last / 5, last / 2, last - last / 7}) {
    const VectorX q = run.joint_position.row(k), dq = run.joint_velocity.row(k), effort = run.torque.row(k);
    REQUIRE(plant.start(run.time[k], q, dq).status == MotionStatus::done);
    const VectorX wanted = run.joint_acceleration.row(k);
    // round-off of the equation of motion, of what is accelerated by some ten units
    CHECK(largest(plant.velocity() - dq) < 1e-10 * (1 + largest(dq)));
    CHECK(largest(plant.acceleration(effort) - wanted) < 1e-8 * (1 + largest(wanted)));
    const Sample& seen = plant.observe(effort);
    for (Eigen::Index i = 0; i < run.axes; ++i)
      CHECK(std::abs(seen.shaking_force[i] - run.shaking_force(k, i)) < 1e-8 * (1 + seen.shaking_force.norm()));
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j)
      for (Eigen::Index i = 0; i < run.axes; ++i)
        CHECK(std::abs(seen.joint_force[j][i] - run.joint_force(k, static_cast<Eigen::Index>(j) * run.axes + i)) <
              1e-7 * (1 + seen.joint_force[j].norm()));
  }
}

}  // namespace

TEST_CASE(
    "where rates are bound, motors that do what inverse dynamics says accelerate the mechanism as it was driven") {
  for (const char* name : machines) {
    const Study study = doors::config(name);
    for (const Trajectory& trajectory : study.trajectories)
      if (trajectory.drive == DriveKind::joints && !trajectory.from.joints.empty() &&
          trajectory.law.kind == MotionLawKind::cycloidal)
        check_ways_agree(study, trajectory);
  }
  check_ways_agree(skating_arm(), skating_arm().trajectories.front());
}

TEST_CASE("where rates are bound, motors supply the change of energy, and what is bound takes none") {
  std::vector<Study> studies{skating_arm()};
  for (const char* name : machines) studies.push_back(doors::config(name));
  for (const Study& study : studies) {
    Trajectory trajectory = study.trajectories.front();
    trajectory.samples = 801;
    CAPTURE(study.mechanism.name);
    const RunResult run = simulate(study.mechanism, trajectory);
    REQUIRE_MESSAGE(run.outcome.status == MotionStatus::done, run.outcome.reason);
    const VectorX energy = run.kinetic_energy + run.potential_energy;
    const VectorX power = run.power.rowwise().sum();
    const double h = run.time[1] - run.time[0], size = largest(power);
    double worst = 0;
    for (Eigen::Index k = 3; k + 3 < energy.size(); ++k) {
      const double slope =
          (45 * (energy[k + 1] - energy[k - 1]) - 9 * (energy[k + 2] - energy[k - 2]) + energy[k + 3] - energy[k - 3]) /
          (60 * h);
      worst = std::max(worst, std::abs(slope - power[k]));
    }
    CHECK(worst < 1e-7 * size);  // what sixth-order differences leave of steps of a thousandth
  }
}

TEST_CASE(
    "conditions hold what velocities allow: a mechanism that meets them has none of what they forbid, along any way") {
  // the cart with its centre of mass above the axle and m b² = I: no velocity terms, and each motor feels its own acceleration alone
  Study study = doors::config("rolling-cart.yaml");
  Body& cart = study.mechanism.bodies[1];
  cart.com.x() = 0;
  cart.inertia(2, 2) = cart.mass * 0.04 - 0.004;  // less what both wheels have about their own axes
  const Conditions found = derive_conditions(study.mechanism, {{GoalKind::decoupled}});
  REQUIRE(found.status == ConditionsStatus::done);
  CHECK(largest(scaled_residuals(found, conditions::term_values(study.mechanism, {}))) < 1e-12);
  Trajectory trajectory = study.trajectories.front();
  trajectory.to.joints.back().value = 0;  // the right wheel stands still
  const RunResult run = simulate(study.mechanism, trajectory);
  REQUIRE(run.outcome.status == MotionStatus::done);
  CHECK(run.torque.col(1).cwiseAbs().maxCoeff() < 1e-12 * run.torque.col(0).cwiseAbs().maxCoeff());
}

TEST_CASE("a constraint that says what holds anyway is redundant, and one too many leaves no motion") {
  Study study = doors::config("sleigh.yaml");
  const RunResult once = simulate(study.mechanism, study.trajectories.front());
  study.mechanism.constraints.push_back(study.mechanism.constraints.front());
  study.mechanism.constraints.back().name = "again";
  study.mechanism.constraints.back().terms.front().factor = -3;
  const RunResult twice = simulate(study.mechanism, study.trajectories.front());
  REQUIRE(twice.outcome.status == MotionStatus::done);
  CHECK((once.torque - twice.torque).cwiseAbs().maxCoeff() < 1e-11 * once.torque.cwiseAbs().maxCoeff());
  CHECK_FALSE(twice.outcome.notes.empty());
}

}  // namespace rolling_test
