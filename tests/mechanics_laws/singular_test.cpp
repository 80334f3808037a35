// Starts and ends at and near singular configurations: right, or refused with time, kind and configuration.

#include "mechanics_check.hpp"

#include "balance/interface/specification/read_spec.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

using namespace laws;
using balance::MotionStatus;

namespace {

constexpr double distances[] = {1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0};

struct Outcome {
  MotionStatus status;
  std::string reason;
};

/// Runs the config's first trajectory with other joint values or another tool at its ends.
struct Trial {
  balance::Study study;
  balance::Trajectory trajectory;

  explicit Trial(const char* file) : study(load(file)), trajectory(study.trajectories.front()) {
    trajectory.samples = 41;
  }
  int coordinate(const std::string& name) const {
    for (std::size_t c = 0; c < study.mechanism.coordinates.size(); ++c)
      if (study.mechanism.coordinates[c].name == name) return static_cast<int>(c);
    FAIL("no coordinate " << name);
    return -1;
  }
  void assemble(const std::vector<std::pair<std::string, double>>& values) {
    study.mechanism.assembly.clear();
    for (const auto& [name, value] : values) study.mechanism.assembly.push_back({coordinate(name), value});
  }
  void drive(const std::string& name, double from, double to) {
    trajectory.drive = balance::DriveKind::joints;
    study.mechanism.actuators = {coordinate(name)};
    trajectory.from = trajectory.to = {};
    trajectory.from.joints = {{coordinate(name), from}};
    trajectory.to.joints = {{coordinate(name), to}};
  }

  /// What came out, after whatever was found has been held against the laws.
  /// @param distance from the singular configuration: round-off over its square is what directions are uncertain by
  MotionStatus run(const std::string& what, double distance = 1) const {
    // the closures are solved to some thirty ulps: the sines of four angles are right to 0.8 of one
    const double tolerance =
        std::clamp(30 * std::numeric_limits<double>::epsilon() / (distance * distance), 1e-7, 1e-3);
    const Run one = attempt(what, study.mechanism, trajectory);
    const balance::MotionOutcome& outcome = one.result.outcome;
    INFO(what << ": " << outcome.reason);
    if (outcome.status == MotionStatus::done) {
      Findings findings;
      judge_instants(one, 9, findings, tolerance);
      CHECK_MESSAGE(findings.none(), findings.text());
      CHECK(one.result.torque.allFinite());
      return outcome.status;
    }
    const bool singular = outcome.status == MotionStatus::drive_singularity ||
                          outcome.status == MotionStatus::constraint_singularity ||
                          outcome.status == MotionStatus::actuation_singularity ||
                          outcome.status == MotionStatus::assembly_jump || outcome.status == MotionStatus::unreachable;
    CHECK(singular);
    if (outcome.status != MotionStatus::unreachable) {
      CHECK(outcome.reason.find("t = ") != std::string::npos);
      CHECK(outcome.reason.find("configuration: ") != std::string::npos);
    }
    CHECK(one.result.torque.size() == 0);
    return outcome.status;
  }
};

bool refused(MotionStatus status) { return status != MotionStatus::done && status != MotionStatus::unsolved; }

}  // namespace

TEST_CASE("a four-bar driven by its rocker starts and ends at its dead centre") {
  // crank and coupler in line: A C = 0.45, so that the rocker's angle follows from the triangle A D C
  const double a = 0.1, b = 0.35, c = 0.25, d = 0.4;
  const double at_A = std::acos((d * d + (a + b) * (a + b) - c * c) / (2 * d * (a + b)));
  const double dead = std::atan2((a + b) * std::sin(at_A), (a + b) * std::cos(at_A) - d);
  for (const double e : distances) {
    Trial trial("four-bar.yaml");
    trial.assemble({{"A", at_A}, {"B", 0.01}, {"D", dead}});
    trial.drive("D", dead + e, dead + 0.3);
    const MotionStatus leaving = trial.run("leaving, " + std::to_string(e), e);
    trial.drive("D", dead + 0.3, dead + e);
    trial.assemble({{"A", at_A - 0.6}, {"B", 1.0}, {"D", dead + 0.3}});
    const MotionStatus arriving = trial.run("arriving, " + std::to_string(e), e);
    if (e == 0) CHECK((refused(leaving) && refused(arriving)));
    if (e >= 1e-5) CHECK((leaving == MotionStatus::done && arriving == MotionStatus::done));
    trial.drive("D", dead + 0.3, dead - 1e-3 - e);  // out of reach
    CHECK(refused(trial.run("beyond", e)));
  }
}

TEST_CASE("a slider-crank driven by its slider starts at its top dead centre") {
  for (const double e : distances) {
    Trial trial("slider-crank.yaml");
    trial.assemble({{"A", 0.01}, {"B", -0.01}, {"S", 0.4}});
    trial.drive("S", 0.4 * (1 - e), 0.35);
    const MotionStatus status = trial.run("from the top, " + std::to_string(e), e);
    if (e == 0) CHECK(refused(status));
    if (e >= 1e-5) CHECK(status == MotionStatus::done);
    trial.drive("S", 0.35, 0.4 * (1 + e));
    trial.assemble({{"A", 0.8}, {"B", -1.0}, {"S", 0.35}});
    CHECK(refused(trial.run("to the top and beyond, " + std::to_string(e), e)));
  }
}

TEST_CASE("a parallelogram at its change point") {
  for (const double e : distances) {
    Trial trial("parallelogram.yaml");
    trial.assemble({{"A", e}, {"D", e}, {"G", e}, {"B", -e}});
    trial.drive("A", e, 1.0);
    trial.run("from flat, " + std::to_string(e), e);
    trial.drive("A", 0.6, e);
    trial.assemble({{"A", 0.6}, {"D", 0.6}, {"G", 0.6}, {"B", -0.6}});
    trial.run("to flat, " + std::to_string(e), e);
    trial.drive("A", 0.6, -0.5);
    trial.run("through flat", e);
  }
}

TEST_CASE("the tool of a five-bar starts and ends with a leg stretched") {
  const balance::Vector3 base(0, 0, 0), along(std::cos(1.0), std::sin(1.0), 0);
  for (const double e : distances) {
    Trial trial("5r.yaml");
    trial.trajectory.drive = balance::DriveKind::tool;
    trial.trajectory.path = balance::trajectory::LinePath{};
    trial.assemble({{"A1", 1.01}, {"B1", -0.02}, {"A2", 0.92}, {"B2", 1.11}});
    const double reach = 0.3 + 0.45;
    trial.trajectory.from = trial.trajectory.to = {};
    trial.trajectory.from.tool = base + reach * (1 - e) * along;
    trial.trajectory.to.tool = base + 0.6 * along;
    const MotionStatus status = trial.run("leaving, " + std::to_string(e), e);
    if (e == 0) CHECK(refused(status));
    if (e >= 1e-5) CHECK(status == MotionStatus::done);
    std::swap(trial.trajectory.from, trial.trajectory.to);
    trial.assemble({{"A1", 1.7}, {"B1", -1.3}, {"A2", 1.0}, {"B2", 1.6}});
    trial.run("arriving, " + std::to_string(e), e);
  }
}

TEST_CASE("a 3RRR turned until its couplers meet in a point is no longer held by its motors") {
  Trial trial("3rrr.yaml");
  trial.trajectory.drive = balance::DriveKind::tool;
  trial.trajectory.path = balance::trajectory::LinePath{};
  trial.trajectory.from = trial.trajectory.to = {};
  trial.trajectory.from.tool = trial.trajectory.to.tool = balance::Vector3(0, 0, 0);
  trial.trajectory.from.angle = 0;
  // the last angle at which the motors still hold it, by halving
  double held = 0, lost = 0;
  for (const double end : {-1.5, 1.5}) {
    trial.trajectory.to.angle = end;
    if (lost == 0 && trial.run("turning") == MotionStatus::actuation_singularity) lost = end;
  }
  REQUIRE(lost != 0);
  for (int k = 0; k < 60; ++k) {
    const double middle = (held + lost) / 2;
    trial.trajectory.to.angle = middle;
    (trial.run("halving", 0) == MotionStatus::done ? held : lost) = middle;
  }
  CHECK(std::abs(held - lost) < 1e-12);
  for (const double e : distances) {
    trial.trajectory.to.angle = held - std::copysign(e, lost);
    // round-off of 1e-15 in the positions moves the smallest pivot, and so the last angle that holds, by some 1e-13
    const bool sure = e >= 1e-12;
    if (sure) CHECK(trial.run("up to " + std::to_string(e), e) == MotionStatus::done);
    trial.trajectory.to.angle = lost + std::copysign(e, lost);
    const MotionStatus beyond = trial.run("beyond by " + std::to_string(e), e);
    if (sure || e == 0) CHECK(beyond == MotionStatus::actuation_singularity);
  }
}

namespace {

constexpr const char* wrist_arm = R"(
name: arm with a wrist
space: spatial
gravity: [0, 0, -9.81]
ground: {points: {O: [0, 0, 0]}}
bodies:
  b1: {mass: 2, com: [0, 0, 0.1], inertia: [0.02, 0.02, 0.01], points: {O: [0, 0, 0], P: [0, 0, 0.3]}}
  b2: {mass: 2, com: [0.2, 0, 0], inertia: [0.01, 0.04, 0.04], points: {O: [0, 0, 0], P: [0.4, 0, 0]}}
  b3: {mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.02, 0.02], points: {O: [0, 0, 0], P: [0.3, 0, 0]}}
  b4: {mass: 0.5, com: [0.01, 0, 0], inertia: [0.001, 0.001, 0.001], points: {O: [0, 0, 0]}}
  b5: {mass: 0.5, com: [0, 0.01, 0], inertia: [0.001, 0.001, 0.001], points: {O: [0, 0, 0]}}
  b6: {mass: 0.5, com: [0.03, 0, 0.02], inertia: [0.001, 0.001, 0.001], points: {O: [0, 0, 0], H: [0.1, 0, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, b1.O], axis: [0, 0, 1]}
  J2: {type: revolute, connects: [b1.P, b2.O], axis: [0, 1, 0]}
  J3: {type: revolute, connects: [b2.P, b3.O], axis: [0, 1, 0]}
  J4: {type: revolute, connects: [b3.P, b4.O], axis: [1, 0, 0]}
  J5: {type: revolute, connects: [b4.O, b5.O], axis: [0, 1, 0]}
  J6: {type: revolute, connects: [b5.O, b6.O], axis: [1, 0, 0]}
actuators: [J1, J2, J3, J4, J5, J6]
tool: b6.H
assembly: {J2: -0.7, J3: 1.1, J5: 0.01}
motion: {duration: 1, samples: 41, from: {joints: {J1: 0.2, J2: -0.7, J3: 1.1, J4: 0.3, J5: 0.4, J6: 0.1}},
         to: {joints: {J1: 0.4, J2: -0.6, J3: 0.9, J4: 0.3, J5: 0.6, J6: 0.3}}}
trajectories: {straight: {law: cycloidal, drive: tool}}
)";

}  // namespace

TEST_CASE("the tool of an arm starts with its wrist, or its elbow, stretched") {
  for (const bool wrist : {true, false})
    for (const double e : distances) {
      Trial trial("rr.yaml");
      trial.study = balance::read_spec(wrist_arm, "arm.yaml");
      trial.trajectory = trial.study.trajectories.front();
      const int bent = trial.coordinate(wrist ? "J5" : "J3");
      for (balance::CoordinateValue& value : trial.trajectory.from.joints)
        if (value.coordinate == bent) value.value = e;
      for (balance::CoordinateValue& value : trial.study.mechanism.assembly)
        if (value.coordinate == bent) value.value = e;
      const MotionStatus status = trial.run((wrist ? "wrist " : "elbow ") + std::to_string(e), e);
      if (e == 0) CHECK(refused(status));
    }
}
