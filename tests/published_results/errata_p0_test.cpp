// Misprints of P0: what is printed fails on a 5R with unlike legs and a payload; what docs/errata.md puts in its place holds.

#include "published.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace published;
using balance::JointType;
using balance::SpaceKind;

namespace {

/// An RR leg as in P0 section 3.2 and eq. 90 to 94.
struct Leg {
  double a1, a2, I1, I2, I3, mu1, mu2;
};

struct FiveBar {
  Mechanism mechanism;
  Leg one, two;
};

constexpr double g = 9.81, base = 0.3;

Leg add_leg(Mechanism& m, std::mt19937& random, double foot, double payload) {
  const double a1 = draw(random, 0.28, 0.34), a2 = draw(random, 0.42, 0.48), c1 = 0.4 * a1, c2 = 0.55 * a2;
  const double m1 = draw(random, 0.5, 2), m2 = draw(random, 0.5, 2), J1 = draw(random, 0.01, 0.02),
               J2 = draw(random, 0.01, 0.02);
  const Vector3 O = Vector3::Zero();
  const int crank = add_body(m, m1, {c1, 0, 0}, J1);
  const int rod = add_body(m, m2, {c2, 0, 0}, J2);
  add_joint(m, JointType::revolute, 0, {foot, 0, 0}, crank, O);
  add_joint(m, JointType::revolute, crank, {a1, 0, 0}, rod, O);
  if (payload > 0) {
    balance::Attachment load;
    load.name = "payload";
    load.kind = balance::AttachmentKind::payload;
    load.body = rod;
    load.position = {a2, 0, 0};
    load.mass = payload;
    m.attachments.push_back(load);
  }
  return {a1,
          a2,
          J2 + m2 * c2 * c2 + payload * a2 * a2,
          J1 + m1 * c1 * c1 + (m2 + payload) * a1 * a1,
          a1 * (m2 * c2 + payload * a2),
          g * (m1 * c1 + (m2 + payload) * a1),
          g * (m2 * c2 + payload * a2)};
}

FiveBar random_five_bar(std::mt19937& random) {
  FiveBar five{empty(SpaceKind::planar, {0, -g, 0}), {}, {}};
  Mechanism& m = five.mechanism;
  five.one = add_leg(m, random, 0, 0.7);
  five.two = add_leg(m, random, base, 0);
  add_joint(m, JointType::revolute, 2, {five.one.a2, 0, 0}, 4, {five.two.a2, 0, 0});
  m.actuators = {0, 2};
  m.assembly = {{1, -1.3}, {3, 1.3}};
  return five;
}

/// Angles q and rates p of both legs as P0 numbers them, and accelerations.
struct State {
  double q11, q12, q21, q22, q33;
  double p11, p12, p21, p22;
  double a11, a12, a21, a22;
};

State state(const RunResult& r, long k) {
  const auto q = r.joint_position.row(k), p = r.joint_velocity.row(k), a = r.joint_acceleration.row(k);
  return {q[0], q[1], q[2], q[3], q[2] + q[3] - q[0] - q[1], p[0], p[1], p[2], p[3], a[0], a[1], a[2], a[3]};
}

/// Terms of eq. 108 and 109 with velocities or weight: what the accelerations leave.
struct Rest {
  double one, two;
};

Rest rest(const RunResult& r, long k, const Leg& A, const Leg& B, const State& s) {
  const double csc = 1 / std::sin(s.q33), sum = std::sin(s.q12 + s.q33), difference = std::sin(s.q22 - s.q33);
  const double c1 = std::cos(s.q12), c2 = std::cos(s.q22);
  const double accelerations_1 = (A.a2 * (A.I2 + c1 * A.I3) - csc * sum * A.a1 * (A.I1 + c1 * A.I3)) / A.a2 * s.a11 +
                                 (c1 * A.I3 - csc * sum * A.a1 * A.I1 / A.a2) * s.a12 -
                                 csc * std::sin(s.q12) * A.a1 / B.a2 * ((B.I1 + c2 * B.I3) * s.a21 + B.I1 * s.a22);
  const double accelerations_2 =
      csc * std::sin(s.q22) * B.a1 / A.a2 * ((A.I1 + c1 * A.I3) * s.a11 + A.I1 * s.a12) +
      (csc * difference * B.a1 * (B.I1 + c2 * B.I3) + B.a2 * (B.I2 + c2 * B.I3)) / B.a2 * s.a21 +
      (csc * difference * B.a1 * B.I1 / B.a2 + c2 * B.I3) * s.a22;
  return {r.torque(k, 0) - accelerations_1, r.torque(k, 1) - accelerations_2};
}

}  // namespace

TEST_CASE("P0 eq. 105: the entry (4, 1) of the 5R's matrix C is negative, as in eq. 107") {
  std::mt19937 random(105);
  for (int trial = 0; trial < 10; ++trial) {
    const FiveBar five = random_five_bar(random);
    const RunResult r =
        run(five.mechanism, joint_motion({0, 2}, Eigen::Vector2d(2.2, 0.9), Eigen::Vector2d(1.9, 1.2), 0.5, 21));
    for (long k = 1; k < 20; ++k) {
      const State s = state(r, k);
      const double printed = std::sin(s.q12) * five.one.a1 / (std::sin(s.q33) * five.two.a2);
      const double rest = (std::sin(s.q22 - s.q33) * five.two.a1 / (std::sin(s.q33) * five.two.a2) - 1) * s.p21;
      const double scale = std::abs(s.p11) + std::abs(s.p21) + std::abs(s.p22);
      CHECK(std::abs(s.p22 - (-printed * s.p11 + rest)) < 1e-11 * scale);
      CHECK(std::abs(s.p22 - (printed * s.p11 + rest)) > 1e-2 * scale);
    }
  }
}

TEST_CASE("P0 eq. 108: the bracket behind a_1,2 ends after mu_2,2's term") {
  std::mt19937 random(108);
  for (int trial = 0; trial < 10; ++trial) {
    const FiveBar five = random_five_bar(random);
    const Leg &A = five.one, &B = five.two;
    const RunResult r =
        run(five.mechanism, joint_motion({0, 2}, Eigen::Vector2d(2.2, 0.9), Eigen::Vector2d(1.9, 1.2), 0.5, 21));
    for (long k = 0; k < 21; ++k) {
      const State s = state(r, k);
      const double csc = 1 / std::sin(s.q33), w = s.p11 + s.p12;
      const double first =
          B.a2 * (A.mu1 * std::cos(s.q11) - A.I3 * w * w * std::sin(s.q12)) -
          A.a1 * std::sin(s.q12) * csc * (B.I3 * s.p21 * s.p21 * std::sin(s.q22) + B.mu2 * std::cos(s.q21 + s.q22));
      const double second = -A.a1 * B.a2 * std::sin(s.q33 + s.q12) * csc *
                            (A.I3 * s.p11 * s.p11 * std::sin(s.q12) + A.mu2 * std::cos(s.q11 + s.q12));
      const double right = (A.a2 * first + second) / (A.a2 * B.a2);
      const double printed = A.a2 * (first + second) / (A.a2 * B.a2);  // closed where the text closes everything
      const double scale = A.mu1 + A.mu2 + B.mu2;
      CHECK(std::abs(rest(r, k, A, B, s).one - right) < 1e-10 * scale);
      CHECK(std::abs(rest(r, k, A, B, s).one - printed) > 1e-3 * scale);
    }
  }
}

TEST_CASE("P0 eq. 109: mu_1,2's term belongs behind I_1,3's, before a_1,2 a_2,2") {
  std::mt19937 random(109);
  for (int trial = 0; trial < 10; ++trial) {
    const FiveBar five = random_five_bar(random);
    const Leg &A = five.one, &B = five.two;
    const RunResult r =
        run(five.mechanism, joint_motion({0, 2}, Eigen::Vector2d(2.2, 0.9), Eigen::Vector2d(1.9, 1.2), 0.5, 21));
    for (long k = 0; k < 21; ++k) {
      const State s = state(r, k);
      const double csc = 1 / std::sin(s.q33), w = s.p21 + s.p22;
      const double own = B.mu1 * std::cos(s.q21) - B.I3 * w * w * std::sin(s.q22);
      const double rod = A.mu2 * std::cos(s.q11 + s.q12), spin = A.I3 * s.p11 * s.p11 * std::sin(s.q12);
      const double second =
          A.a2 * std::sin(s.q22 - s.q33) * (B.I3 * s.p21 * s.p21 * std::sin(s.q22) + B.mu2 * std::cos(s.q21 + s.q22));
      const double size = A.a2 * B.a2;
      const double right = (B.a1 * csc * (second + B.a2 * std::sin(s.q22) * (spin + rod)) + size * own) / size;
      const double printed = B.a1 * csc * (second + B.a2 * std::sin(s.q22) * (spin + size * own + rod)) / size;
      const double scale = B.mu1 + A.mu2 + B.mu2;
      CHECK(std::abs(rest(r, k, A, B, s).two - right) < 1e-10 * scale);
      CHECK(std::abs(rest(r, k, A, B, s).two - printed) > 1e-3 * scale);
    }
  }
}
