// What a mechanism cannot do is said with the time and the reason, never answered by wrong numbers.

#include "published.hpp"

#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace published;
using balance::JointType;
using balance::SpaceKind;

namespace {

const Vector3 O = Vector3::Zero();

/// Two links with the tool at the tip; reach from |a1 - a2| to a1 + a2.
Mechanism arm(double a1, double a2) {
  Mechanism m = empty(SpaceKind::planar, {0, -9.81, 0});
  add_body(m, 1, {a1 / 2, 0, 0}, 0.01);
  add_body(m, 1, {a2 / 2, 0, 0}, 0.01);
  m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O), add_joint(m, JointType::revolute, 1, {a1, 0, 0}, 2, O)};
  m.tool = balance::Tool{2, "tip", {a2, 0, 0}};
  m.assembly = {{1, 1.0}};
  return m;
}

Trajectory line(const Vector3& from, const Vector3& to) {
  Trajectory t;
  t.name = "line";
  t.law.kind = balance::MotionLawKind::uniform;
  t.from.tool = from;
  t.to.tool = to;
  t.duration = 2;
  t.samples = 101;
  return t;
}

}  // namespace

TEST_CASE("an arm driven through its stretched position stops there with a drive singularity") {
  const Mechanism m = arm(0.5, 0.4);
  Trajectory t = line({0.45, 0.1, 0}, {0.45, 0.1, 0});
  // a circle of radius 0.3 about (0.75, 0.1) leaves the reach of 0.9 where |centre + 0.3 e| = 0.9
  balance::trajectory::CirclePath circle;
  circle.centre = {0.75, 0.1, 0};
  circle.angle = 2 * std::numbers::pi;
  t.path = circle;
  const RunResult r = balance::simulate(m, t);
  CHECK(r.outcome.status == MotionStatus::drive_singularity);
  double out = 0;  // first angle at which the circle leaves the reach, by bisection
  const auto reach = [&](double a) { return (circle.centre + 0.3 * Vector3(-std::cos(a), -std::sin(a), 0)).norm(); };
  while (reach(out) < 0.9) out += 1e-3;
  for (double low = out - 1e-3, high = out; high - low > 1e-12;) {
    out = 0.5 * (low + high);
    (reach(out) < 0.9 ? low : high) = out;
  }
  CHECK(r.outcome.time == doctest::Approx(2 * out / circle.angle).epsilon(1e-5));
  CHECK(r.outcome.reason.find("drive singularity") != std::string::npos);
  CHECK(r.torque.size() == 0);
}

TEST_CASE("an arm driven through the hole in the middle of its reach stops at the hole's edge") {
  const Mechanism m = arm(0.5, 0.4);  // the hole has the radius 0.1
  const RunResult r = balance::simulate(m, line({0.4, 0.06, 0}, {-0.4, 0.06, 0}));
  CHECK(r.outcome.status == MotionStatus::drive_singularity);
  CHECK(r.outcome.time == doctest::Approx(2 * (0.4 - 0.08) / 0.8).epsilon(1e-5));
}

TEST_CASE("a start that cannot be reached is called unreachable") {
  const RunResult r = balance::simulate(arm(0.5, 0.4), line({0.8, 0.5, 0}, {0.3, 0.3, 0}));
  CHECK(r.outcome.status == MotionStatus::unreachable);
  CHECK(r.outcome.reason.find("start") != std::string::npos);
  CHECK(r.time.size() == 0);
}

TEST_CASE("an end that cannot be reached stops the run: where the way leaves the reach, or before it begins") {
  const RunResult r = balance::simulate(arm(0.5, 0.4), line({0.5, 0, 0}, {1.5, 0, 0}));
  const bool said =
      r.outcome.status == MotionStatus::unreachable || r.outcome.status == MotionStatus::drive_singularity;
  CHECK(said);
  if (r.outcome.status == MotionStatus::drive_singularity)
    CHECK(r.outcome.time == doctest::Approx(2 * 0.4).epsilon(1e-5));
  CHECK(r.time.size() == 0);
}

TEST_CASE("the platform of 3rrr.yaml sent out of reach stops the run") {
  const balance::Study study = load("3rrr.yaml");
  Trajectory t = make_trajectory(study, "cycloid", 101);
  t.from.tool = Vector3(1, 1, 0);
  CHECK(balance::simulate(study.mechanism, t).outcome.status == MotionStatus::unreachable);
  t = make_trajectory(study, "cycloid", 101);
  t.to.tool = Vector3(0.6, 0, 0);
  const RunResult r = balance::simulate(study.mechanism, t);
  CHECK(r.outcome.status != MotionStatus::done);
  CHECK(r.outcome.status != MotionStatus::unsolved);
  CHECK(!r.outcome.reason.empty());
}

TEST_CASE("a four-bar with a coupler that is too short cannot be assembled, and the open joint is named") {
  Mechanism m = empty(SpaceKind::planar, O);
  add_body(m, 1, {0.05, 0, 0}, 0.001);
  add_body(m, 1, {0.05, 0, 0}, 0.001);
  add_body(m, 1, {0.05, 0, 0}, 0.001);
  m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O)};
  add_joint(m, JointType::revolute, 1, {0.1, 0, 0}, 2, O);
  add_joint(m, JointType::revolute, 2, {0.1, 0, 0}, 3, {0.1, 0, 0});
  add_joint(m, JointType::revolute, 0, {0.5, 0, 0}, 3, O);
  const VectorX from = VectorX::Constant(1, 0.3), to = VectorX::Constant(1, 0.5);
  const RunResult r = balance::simulate(m, joint_motion({0}, from, to, 1, 11));
  CHECK(r.outcome.status == MotionStatus::not_assembled);
  CHECK(r.outcome.reason.find("0.2") != std::string::npos);  // 0.5 - 3 * 0.1 stays open
  CHECK(r.time.size() == 0);
}

TEST_CASE("a crank that cannot turn fully stops where the other links stretch") {
  // 0.3 + 0.35 + 0.25 against the base 0.4: a non-Grashof triple rocker
  balance::Study study = load("four-bar.yaml");
  Mechanism m = study.mechanism;
  m.joints[1].point_first.x() = 0.3;  // the crank's end
  Trajectory t = make_trajectory(study, "steady", 201);
  t.from.joints[0].value = 1;
  t.to.joints[0].value = 1 + 2 * std::numbers::pi;
  const RunResult r = balance::simulate(m, t);
  CHECK(r.outcome.status == MotionStatus::drive_singularity);
  // coupler and rocker in one line: 0.6^2 = 0.3^2 + 0.4^2 - 2 0.3 0.4 cos(angle)
  const double angle = std::acos((0.09 + 0.16 - 0.36) / 0.24);
  CHECK(r.outcome.time == doctest::Approx(0.5 * (angle - 1) / (2 * std::numbers::pi)).epsilon(1e-5));
}

TEST_CASE("a 3RRR whose platform turns until the couplers' lines meet stops with an actuation singularity") {
  const balance::Study study = load("3rrr.yaml");
  Trajectory t = make_trajectory(study, "cycloid", 2001);
  t.law.kind = balance::MotionLawKind::uniform;
  t.from = {}, t.to = {};
  t.from.tool = t.to.tool = Vector3(0.01, -0.02, 0);
  t.from.angle = 0, t.to.angle = 0.2;
  // where the determinant of the couplers' lines (directions and moments about the tool) changes its sign
  const auto lines = [&](const RunResult& r, long k) {
    Matrix3 W;
    const Eigen::Vector2d H = r.tool_position.row(k);
    const Vector3 A[3] = {{0.21651, -0.125, 0}, {-0.21651, -0.125, 0}, {0, 0.25, 0}};
    for (int leg = 0; leg < 3; ++leg) {
      const std::string n = std::to_string(leg + 1);
      const double p = r.joint_position(k, coordinate(study.mechanism, "A" + n));
      const double q = p + r.joint_position(k, coordinate(study.mechanism, "B" + n));
      const Eigen::Vector2d B = A[leg].head<2>() + 0.18 * Eigen::Vector2d(std::cos(p), std::sin(p)) - H;
      const Eigen::Vector2d e(std::cos(q), std::sin(q));
      W.row(leg) << e.x(), e.y(), (B.x() * e.y() - B.y() * e.x()) / 0.1;
    }
    return W.determinant();
  };
  // search in pieces: a run ends where the grip is lost
  double low = 0, high = -1;
  for (const double sense : {1.0, -1.0}) {
    for (int k = 1; k <= 30 && high < 0; ++k) {
      t.to.angle = sense * 0.1 * k;
      const RunResult r = balance::simulate(study.mechanism, t);
      if (r.outcome.status == MotionStatus::actuation_singularity) {
        high = 0.1 * k;
        CHECK(r.outcome.reason.find("actuation singularity") != std::string::npos);
        CHECK(r.torque.size() == 0);
        // just before it the lines nearly meet
        const double angle = *t.to.angle * r.outcome.time / t.duration;
        Trajectory before = t;
        before.to.angle = angle * (1 - 2e-3);
        before.samples = 11;
        const RunResult near = run(study.mechanism, before);
        CHECK(std::abs(lines(near, 10)) < 0.05 * std::abs(lines(near, 0)));
      } else if (r.outcome.status == MotionStatus::done) {
        low = 0.1 * k;
        CHECK(lines(r, 0) * lines(r, 2000) > 0);  // a sign change must not pass unnoticed
      } else {
        break;
      }
    }
    if (high > 0) break;
  }
  CHECK(high > low);
}

TEST_CASE("too few actuators are a mismatch, said in numbers") {
  balance::Study study = load("3rrr.yaml");
  study.mechanism.actuators.pop_back();
  const RunResult r = balance::simulate(study.mechanism, make_trajectory(study, "cycloid", 11));
  CHECK(r.outcome.status == MotionStatus::mismatch);
  CHECK(r.outcome.reason.find("2 actuators") != std::string::npos);
  CHECK(r.outcome.reason.find("3 degrees") != std::string::npos);
}

TEST_CASE("too many actuators share the work with least norm, and the power is the same") {
  balance::Study study = load("3rrr.yaml");
  const Trajectory t = make_trajectory(study, "cycloid", 51);
  const RunResult alone = run(study.mechanism, t);
  study.mechanism.actuators.push_back(static_cast<int>(coordinate(study.mechanism, "B1")));
  const RunResult shared = run(study.mechanism, t);
  REQUIRE(shared.outcome.notes.size() == 2);
  CHECK(shared.outcome.notes[0].find("over-actuated") != std::string::npos);
  // The motors without A1 would stop there, which they do when A1 is left out.
  CHECK(shared.outcome.notes[1].find("singularity of the actuators other than A1") != std::string::npos);
  study.mechanism.actuators.erase(study.mechanism.actuators.begin());
  const RunResult without = balance::simulate(study.mechanism, t);
  CHECK(without.outcome.status == MotionStatus::actuation_singularity);
  CHECK(without.outcome.time == doctest::Approx(0.0380672).epsilon(1e-5));
  const double power = alone.power.rowwise().sum().cwiseAbs().maxCoeff();
  for (long k = 0; k < 51; ++k) {
    CHECK(std::abs(shared.power.row(k).sum() - alone.power.row(k).sum()) < 1e-10 * power);
    CHECK(shared.torque.row(k).norm() <= alone.torque.row(k).norm() * (1 + 1e-12));
  }
  CHECK((shared.shaking_force - alone.shaking_force).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("two motors on one freedom carry half each") {
  Mechanism m = empty(SpaceKind::planar, O);
  add_body(m, 1, O, 0.02);
  add_body(m, 1, O, 0.02);
  m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O),
                 add_joint(m, JointType::revolute, 0, {0.3, 0, 0}, 2, O)};
  m.couplings.push_back({1, 0, 1, 0});
  const VectorX from = VectorX::Constant(1, 0), to = VectorX::Constant(1, 2);
  const RunResult r = run(m, joint_motion({0}, from, to, 1, 21));
  CHECK((r.torque.col(0) - r.torque.col(1)).cwiseAbs().maxCoeff() < 1e-14);
  CHECK((2 * r.torque.col(0) - 0.04 * r.joint_acceleration.col(0)).cwiseAbs().maxCoeff() < 1e-13);
}

TEST_CASE("a drive with more or fewer values than freedoms is a mismatch") {
  const balance::Study study = load("four-bar.yaml");
  Trajectory t = joint_motion({}, VectorX(), VectorX(), 1, 11);
  t.drive = balance::DriveKind::tool;
  t.components = {balance::trajectory::Component::x, balance::trajectory::Component::y};
  t.from.tool = Vector3(0.2, 0.3, 0), t.to.tool = Vector3(0.25, 0.3, 0);
  const RunResult r = balance::simulate(study.mechanism, t);
  CHECK(r.outcome.status != MotionStatus::done);
  CHECK(!r.outcome.reason.empty());
}

TEST_CASE("a run that stops says where: the spec's coordinates by name") {
  const RunResult r = balance::simulate(arm(0.5, 0.4), line({0.4, 0.06, 0}, {-0.4, 0.06, 0}));
  CHECK(r.outcome.reason.find("J1 ") != std::string::npos);
  CHECK(r.outcome.reason.find("J2 ") != std::string::npos);
  CHECK(r.outcome.reason.find("t = ") != std::string::npos);
}

TEST_CASE("few samples hide nothing: a way through the hole in the reach is never done") {
  const Mechanism m = arm(0.5, 0.4);
  for (const long samples : {2, 3, 4, 5, 8, 13, 50}) {
    CAPTURE(samples);
    Trajectory t = line({0.4, 0.06, 0}, {-0.4, 0.06, 0});
    t.samples = samples;
    CHECK(balance::simulate(m, t).outcome.status != MotionStatus::done);
  }
}

TEST_CASE("few samples hide nothing: a crank that cannot turn fully never does") {
  const balance::Study study = load("four-bar.yaml");
  Mechanism m = study.mechanism;
  m.joints[1].point_first.x() = 0.3;
  for (const long samples : {2, 3, 4, 5, 8, 13, 50}) {
    CAPTURE(samples);
    Trajectory t = make_trajectory(study, "steady", samples);
    t.from.joints[0].value = 1;
    t.to.joints[0].value = 1 + 2 * std::numbers::pi;
    CHECK(balance::simulate(m, t).outcome.status != MotionStatus::done);
  }
}

TEST_CASE("few samples change nothing: whatever the grid, the same configuration is reached") {
  for (const std::string file :
       {"3rrr.yaml", "four-bar.yaml", "whitworth.yaml", "stewart.yaml", "delta.yaml", "spatial-slider-crank.yaml"}) {
    const balance::Study study = load(file);
    const RunResult fine = run(study.mechanism, make_trajectory(study, "cycloid", 401));
    for (const long samples : {2, 3, 5, 9}) {
      CAPTURE(file);
      CAPTURE(samples);
      const RunResult coarse = run(study.mechanism, make_trajectory(study, "cycloid", samples));
      for (long k = 0; k < samples; ++k) {
        const long same = k * 400 / (samples - 1);
        for (long c = 0; c < fine.joint_position.cols(); ++c) {
          double off = coarse.joint_position(k, c) - fine.joint_position(same, c);
          // whole turns of an angle that is read off the poses cannot be counted from half a turn apart
          if (fine.coordinate_units[static_cast<std::size_t>(c)] == "rad")
            off = std::remainder(off, 2 * std::numbers::pi);
          CHECK(std::abs(off) < 1e-8);
        }
        CHECK((coarse.torque.row(k) - fine.torque.row(same)).cwiseAbs().maxCoeff() <
              1e-8 * fine.torque.cwiseAbs().maxCoeff());
      }
    }
  }
}
