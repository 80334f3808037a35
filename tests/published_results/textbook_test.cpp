// Mechanisms whose motion and torque every textbook gives in closed form.

#include "published.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace textbook_test {

using namespace published;
using balance::JointType;
using balance::SpaceKind;

namespace {

constexpr double g = 9.81;
const Vector3 O = Vector3::Zero();

VectorX values(double a) { return VectorX::Constant(1, a); }
VectorX values(double a, double b) { return Eigen::Vector2d(a, b); }

}  // namespace

TEST_CASE("physical pendulum: torque = (J + m c^2) q'' + m g c sin q") {
  Mechanism m = empty(SpaceKind::planar, {0, -g, 0});
  add_body(m, 2.5, {0, -0.3, 0}, 0.04);
  m.actuators = {add_joint(m, JointType::revolute, 0, {0.1, 0.2, 0}, 1, O)};
  const RunResult r = run(m, joint_motion({0}, values(-2.5), values(3), 0.8, 41));
  for (long k = 0; k < 41; ++k) {
    const double want =
        (0.04 + 2.5 * 0.09) * r.joint_acceleration(k, 0) + 2.5 * g * 0.3 * std::sin(r.joint_position(k, 0));
    CHECK(std::abs(r.torque(k, 0) - want) < 1e-13 * r.torque.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("the same pendulum in space, about any axis across gravity") {
  for (const double turn : {0.0, 0.8, 2.0}) {
    Mechanism m = empty(SpaceKind::spatial, {0, 0, -g});
    add_body(m, 2.5, {0, 0, -0.3}, Matrix3(Vector3(0.04, 0.04, 0.01).asDiagonal()));
    m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O, {std::cos(turn), std::sin(turn), 0})};
    const RunResult r = run(m, joint_motion({0}, values(-2.5), values(3), 0.8, 41));
    for (long k = 0; k < 41; ++k) {
      const double want =
          (0.04 + 2.5 * 0.09) * r.joint_acceleration(k, 0) + 2.5 * g * 0.3 * std::sin(r.joint_position(k, 0));
      CHECK(std::abs(r.torque(k, 0) - want) < 1e-13 * r.torque.cwiseAbs().maxCoeff());
    }
  }
}

TEST_CASE("double pendulum of two uniform rods: Lagrange's equations") {
  const RunResult r = run("double-pendulum.yaml", "cycloid", 101);
  const double scale = r.torque.cwiseAbs().maxCoeff();
  for (long k = 0; k < 101; ++k) {  // rods of 1 kg and 1 m, absolute angles a and b from the vertical
    const auto q = r.joint_position.row(k), p = r.joint_velocity.row(k), w = r.joint_acceleration.row(k);
    const double a = q[0], b = q[0] + q[1], da = p[0], db = p[0] + p[1], dda = w[0], ddb = w[0] + w[1];
    const double on_a =
        (4.0 / 3) * dda + 0.5 * ddb * std::cos(a - b) + 0.5 * db * db * std::sin(a - b) + 1.5 * g * std::sin(a);
    const double on_b =
        (1.0 / 3) * ddb + 0.5 * dda * std::cos(a - b) - 0.5 * da * da * std::sin(a - b) + 0.5 * g * std::sin(b);
    CHECK(std::abs(r.torque(k, 1) - on_b) < 1e-12 * scale);
    CHECK(std::abs(r.torque(k, 0) - on_a - on_b) < 1e-12 * scale);
  }
}

TEST_CASE("Scotch yoke: the displacement is exactly r cos A, and the crank feels the yoke's inertia through it") {
  const balance::Study study = load("scotch-yoke.yaml");
  for (const std::string name : {"cycloid", "steady"}) {
    const RunResult r = run(study.mechanism, make_trajectory(study, name, 101));
    const long A = coordinate(study.mechanism, "A"), S = coordinate(study.mechanism, "S");
    for (long k = 0; k < 101; ++k) {
      const double angle = r.joint_position(k, A), w = r.joint_velocity(k, A), a = r.joint_acceleration(k, A);
      const double slope = -0.08 * std::sin(angle), bend = -0.08 * std::cos(angle);
      const double x2 = slope * a + bend * w * w;
      CHECK(std::abs(r.joint_position(k, S) - 0.08 * std::cos(angle)) < 1e-13);
      CHECK(std::abs(r.joint_velocity(k, S) - slope * w) < 1e-12 * 0.08 * 100);
      CHECK(std::abs(r.joint_acceleration(k, S) - x2) < 1e-11 * 0.08 * 10000);
      const double want = (0.002 + 1 * 0.02 * 0.02) * a + 1 * g * 0.02 * std::cos(angle) + 1.5 * x2 * slope;
      CHECK(std::abs(r.torque(k, 0) - want) < 1e-11 * r.torque.cwiseAbs().maxCoeff());
    }
  }
}

TEST_CASE("slider-crank: the piston's position, velocity and acceleration by the exact formula") {
  const balance::Study study = load("slider-crank.yaml");
  const double R = 0.1, l = 0.3;
  for (const std::string name : {"cycloid", "steady"}) {
    const RunResult r = run(study.mechanism, make_trajectory(study, name, 101));
    const long A = coordinate(study.mechanism, "A"), S = coordinate(study.mechanism, "S");
    for (long k = 0; k < 101; ++k) {
      const double t = r.joint_position(k, A), w = r.joint_velocity(k, A), a = r.joint_acceleration(k, A);
      const double s = std::sin(t), c = std::cos(t), root = std::sqrt(l * l - R * R * s * s);
      const double slope = -R * s - R * R * s * c / root;
      const double bend =
          -R * c - R * R * (c * c - s * s) / root - R * R * R * R * s * s * c * c / (root * root * root);
      CHECK(std::abs(r.joint_position(k, S) - R * c - root) < 1e-12);
      CHECK(std::abs(r.joint_velocity(k, S) - slope * w) <
            1e-12 * std::max(1.0, r.joint_velocity.cwiseAbs().maxCoeff()));
      CHECK(std::abs(r.joint_acceleration(k, S) - slope * a - bend * w * w) <
            1e-11 * r.joint_acceleration.cwiseAbs().maxCoeff());
    }
  }
}

TEST_CASE("four-bar: Freudenstein's equation") {
  const balance::Study study = load("four-bar.yaml");
  const double a = 0.1, b = 0.35, c = 0.25, d = 0.4;
  const RunResult r = run(study.mechanism, make_trajectory(study, "steady", 201));
  for (long k = 0; k < 201; ++k) {
    const double in = r.joint_position(k, coordinate(study.mechanism, "A")),
                 out = r.joint_position(k, coordinate(study.mechanism, "D"));
    const double left = d / a * std::cos(out) - d / c * std::cos(in) + (a * a - b * b + c * c + d * d) / (2 * a * c);
    CHECK(std::abs(left - std::cos(in - out)) < 1e-10);  // lengths are closed to 1e-12 and divided by a c
  }
}

TEST_CASE("quick-return shaper: lever angle, ram and time ratio") {
  const balance::Study study = load("whitworth.yaml");
  const double R = 0.1, d = 0.25, lever = 0.5, link = 0.2;
  const long N = 3601;
  const RunResult r = run(study.mechanism, make_trajectory(study, "steady", N));
  const long A = coordinate(study.mechanism, "O"), Q = coordinate(study.mechanism, "Q"),
             S = coordinate(study.mechanism, "R");
  long first = 0, last = 0;
  for (long k = 0; k < N; ++k) {
    const double t = r.joint_position(k, A), angle = std::atan2(R * std::sin(t) + d, R * std::cos(t));
    CHECK(std::abs(r.joint_position(k, Q) - angle) < 1e-11);
    const double rise = lever - lever * std::sin(angle);
    CHECK(std::abs(r.joint_position(k, S) - lever * std::cos(angle) - std::sqrt(link * link - rise * rise)) < 1e-11);
    if (r.joint_position(k, Q) > r.joint_position(first, Q)) first = k;
    if (r.joint_position(k, Q) < r.joint_position(last, Q)) last = k;
  }
  // the lever stands still where the crank is at right angles to it, asin(r / d) from the upright on either side
  const double swing = std::asin(R / d), step = 2 * std::numbers::pi / (N - 1);
  CHECK(std::abs(r.joint_position(first, Q) - std::numbers::pi / 2 - swing) < 1e-5);
  CHECK(std::abs(r.joint_position(last, Q) - std::numbers::pi / 2 + swing) < 1e-5);
  const double turn = std::remainder(r.joint_position(last, A) - r.joint_position(first, A), 2 * std::numbers::pi);
  CHECK(std::abs(std::abs(turn) - (std::numbers::pi - 2 * swing)) < 2 * step);  // the shorter way: the return stroke
}

TEST_CASE("geared shafts: the motor feels J1 + n^2 J2") {
  for (const double n : {-3.0, 0.25, 7.0}) {
    Mechanism m = empty(SpaceKind::planar, {0, -g, 0});
    add_body(m, 1, O, 0.02);
    add_body(m, 1, O, 0.005);
    m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O)};
    add_joint(m, JointType::revolute, 0, {0.3, 0, 0}, 2, O);
    m.couplings.push_back({1, 0, n, 0.1});
    const RunResult r = run(m, joint_motion({0}, values(0), values(5), 0.5, 21));
    for (long k = 0; k < 21; ++k) {
      CHECK(std::abs(r.torque(k, 0) - (0.02 + n * n * 0.005) * r.joint_acceleration(k, 0)) <
            1e-13 * r.torque.cwiseAbs().maxCoeff());
      CHECK(std::abs(r.shaking_moment(k, 0) - (0.02 + n * 0.005) * r.joint_acceleration(k, 0)) <
            1e-13 * r.torque.cwiseAbs().maxCoeff());
    }
  }
}

TEST_CASE("rack and pinion: a sliding mass at radius r adds m r^2") {
  Mechanism m = empty(SpaceKind::planar, O);
  add_body(m, 1, O, 0.02);
  add_body(m, 3, O, 0.005);
  m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O)};
  add_joint(m, JointType::prismatic, 0, {0, 0.05, 0}, 2, O, Vector3::UnitX());
  m.couplings.push_back({1, 0, -0.05, 0});
  const RunResult r = run(m, joint_motion({0}, values(0), values(5), 0.5, 21));
  for (long k = 0; k < 21; ++k)
    CHECK(std::abs(r.torque(k, 0) - (0.02 + 3 * 0.0025) * r.joint_acceleration(k, 0)) <
          1e-13 * r.torque.cwiseAbs().maxCoeff());
}

TEST_CASE("a disc on an arm that follows the arm's own joint: J + m d^2 + Jd (1 + ratio)^2") {
  for (const double ratio : {-1.0, 0.5, -4.0}) {
    Mechanism m = empty(SpaceKind::planar, O);
    add_body(m, 2, {0.2, 0, 0}, 0.03);
    m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O)};
    add_disc(m, 1, {0.3, 0.1, 0}, Vector3::UnitZ(), 0, ratio, 0.7, about_z(0.004));
    const RunResult r = run(m, joint_motion({0}, values(0), values(2), 0.5, 21));
    const double carried = 0.03 + 2 * 0.04 + 0.7 * 0.1, spin = 1 + ratio;
    for (long k = 0; k < 21; ++k) {
      const double a = r.joint_acceleration(k, 0), scale = 1e-13 * r.torque.cwiseAbs().maxCoeff();
      CHECK(std::abs(r.torque(k, 0) - (carried + 0.004 * spin * spin) * a) < scale);
      CHECK(std::abs(r.shaking_moment(k, 0) - (carried + 0.004 * spin) * a) < scale);
    }
  }
}

TEST_CASE("a gyroscope: turning a spinning rotor's axis takes the moment Omega x J omega") {
  // a fork turns steadily about z and carries a rotor that spins steadily about its own x axis
  Mechanism m = empty(SpaceKind::spatial, O);
  const Matrix3 inertia = Vector3(0.01, 0.006, 0.006).asDiagonal();
  add_body(m, 1, O, Matrix3(0.1 * Matrix3::Identity()));
  add_body(m, 2, O, inertia);
  m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O),
                 add_joint(m, JointType::revolute, 1, O, 2, O, Vector3::UnitX())};
  Trajectory t = joint_motion({0, 1}, values(0, 0), values(2, 50), 1, 21);
  t.law.kind = balance::MotionLawKind::uniform;
  const RunResult r = run(m, t);
  for (long k = 0; k < 21; ++k) {
    const double a = r.joint_position(k, 0);
    const Vector3 along(std::cos(a), std::sin(a), 0), want = Vector3(0, 0, 2).cross(0.01 * 50 * along);
    CHECK((r.shaking_moment.row(k).transpose() - want).norm() < 1e-12);
    CHECK((r.joint_moment.row(k).segment<3>(3).transpose() - want).norm() < 1e-12);
    CHECK(r.torque.row(k).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("Coriolis: a mass sliding outwards on a turning rod presses on it with 2 m w v") {
  Mechanism m = empty(SpaceKind::planar, O);
  add_body(m, 1, O, 0.1);
  add_body(m, 2, O, 0.001);
  m.actuators = {add_joint(m, JointType::revolute, 0, O, 1, O),
                 add_joint(m, JointType::prismatic, 1, O, 2, O, Vector3::UnitX())};
  Trajectory t = joint_motion({0, 1}, values(0, 0.1), values(3, 0.5), 1, 21);
  t.law.kind = balance::MotionLawKind::uniform;
  const RunResult r = run(m, t);
  for (long k = 0; k < 21; ++k) {
    const double x = r.joint_position(k, 1), a = r.joint_position(k, 0);
    CHECK(r.torque(k, 0) == doctest::Approx(2 * 2 * 3 * 0.4 * x).epsilon(1e-12));
    CHECK(r.torque(k, 1) == doctest::Approx(-2 * 9 * x).epsilon(1e-12));
    const Eigen::Vector2d across(-std::sin(a), std::cos(a)), force = r.joint_force.row(k).segment<2>(2);
    CHECK(force.dot(across) == doctest::Approx(2 * 2 * 3 * 0.4).epsilon(1e-12));
  }
}

TEST_CASE("a mass sent by bang-bang: every metric in closed form, wherever the jump falls between the samples") {
  const double mass = 2, way = 0.6, T = 0.5, force = 4 * mass * way / (T * T);
  for (const long samples : {2, 3, 10, 101, 1000}) {
    CAPTURE(samples);
    Mechanism m = empty(SpaceKind::planar, O);
    add_body(m, mass, {0, 0.1, 0}, 0.01);
    m.actuators = {add_joint(m, JointType::prismatic, 0, O, 1, O, Vector3::UnitX())};
    Trajectory t = joint_motion({0}, values(0), values(way), T, samples);
    t.law.kind = balance::MotionLawKind::bang_bang;
    const RunResult r = run(m, t);
    for (const std::string quantity : {"shaking_force", "torque", "force[J1]"}) {
      CAPTURE(quantity);
      CHECK(metric(r, quantity).peak == doctest::Approx(force).epsilon(1e-13));
      CHECK(metric(r, quantity).rms == doctest::Approx(force).epsilon(1e-13));
      CHECK(metric(r, quantity).mean == doctest::Approx(force).epsilon(1e-13));
    }
    CHECK(metric(r, "force[J1]").range == doctest::Approx(2 * force).epsilon(1e-13));
    CHECK(std::abs(metric(r, "shaking_force").range) < 1e-13 * force);
    CHECK(metric(r, "shaking_moment").peak == doctest::Approx(0.1 * force).epsilon(1e-13));
    // the motor gives the mass its kinetic energy and takes it back
    CHECK(r.energy == doctest::Approx(2 * 0.5 * mass * 4 * way * way / (T * T)).epsilon(1e-13));
  }
}

TEST_CASE("rms, mean and energy of a smooth motion meet their integrals") {
  // harmonic law: x'' = L w^2 / 2 cos(w t), w = pi / T
  const double mass = 2, way = 0.6, T = 0.5, w = std::numbers::pi / T, top = mass * way * w * w / 2;
  Mechanism m = empty(SpaceKind::planar, O);
  add_body(m, mass, O, 0.01);
  m.actuators = {add_joint(m, JointType::prismatic, 0, O, 1, O, Vector3::UnitX())};
  Trajectory t = joint_motion({0}, values(0), values(way), T, 2001);
  t.law.kind = balance::MotionLawKind::harmonic;
  const RunResult r = run(m, t);
  // trapezoidal rule on 2,001 samples: error of the order 1e-6
  CHECK(metric(r, "shaking_force").peak == doctest::Approx(top).epsilon(1e-13));
  CHECK(metric(r, "shaking_force").rms == doctest::Approx(top / std::sqrt(2.0)).epsilon(1e-6));
  CHECK(metric(r, "shaking_force").mean == doctest::Approx(top * 2 / std::numbers::pi).epsilon(1e-6));
  CHECK(r.energy == doctest::Approx(mass * std::pow(way * w / 2, 2)).epsilon(1e-5));
}

}  // namespace textbook_test
