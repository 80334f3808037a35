// Misprints of P1 section 3.2: torques of a spatial RRR arm that meets the static condition eq. 30 and nothing else.
// Coefficients as in eq. 14 and 15. What is printed fails; what docs/errata.md puts in its place holds.

#include "published.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace errata_p1_test {

using namespace published;
using balance::JointType;
using balance::SpaceKind;

namespace {

double sin2(double x) { return std::sin(x) * std::sin(x); }
double cos2(double x) { return std::cos(x) * std::cos(x); }

struct Numbers {
  double l1, l2, m2, m3;
  double Jz1, Jx2, Jy2, Jz2, Jx3, Jy3, Jz3;
  double ratio = 0;  ///< β: of the body that takes a second disc's place
  double J4x = 0, J4y = 0, J4z = 0, J5x = 0, J5y = 0, J5z = 0;
};

Numbers draw_numbers(std::mt19937& random) {
  const auto any = [&] { return draw(random, 0.5, 1.5); };
  Numbers n{any(), any(), any(), any(), any(), any(), any(), any(), any(), any(), any()};
  return n;
}

Matrix3 diagonal(double x, double y, double z) { return Vector3(x, y, z).asDiagonal(); }

Mechanism arm(const Numbers& n) {
  const Vector3 O = Vector3::Zero(), x = Vector3::UnitX();
  Mechanism m = empty(SpaceKind::spatial, {0, 0, -9.81});
  add_body(m, 1, O, diagonal(1, 1, n.Jz1));
  add_body(m, n.m2, {0, -n.l2 * n.m3 / n.m2, 0}, diagonal(n.Jx2, n.Jy2, n.Jz2));
  add_body(m, n.m3, O, diagonal(n.Jx3, n.Jy3, n.Jz3));
  add_joint(m, JointType::revolute, 0, O, 1, O);
  add_joint(m, JointType::revolute, 1, {0, n.l1, 0}, 2, O, x);
  add_joint(m, JointType::revolute, 2, {0, n.l2, 0}, 3, O, x);
  m.actuators = {0, 1, 2};
  return m;
}

/// The coefficients of eq. 14 and 15 that are not zero at one configuration.
struct Coefficients {
  double D11 = 0, D22 = 0, D33 = 0, D23 = 0;
  double D112 = 0, D113 = 0, D211 = 0, D311 = 0;
};

/// Eq. 31 with the sums that the errata are about left open.
Coefficients eq31(const Numbers& n, double t2, double t3, double D22_mass, bool shift_in_2) {
  const double s22 = std::sin(2 * t2), s23 = std::sin(2 * t2 + 2 * t3);
  const double shift = n.m3 * n.l2 * n.l2 * (1 + n.m3 / n.m2);
  Coefficients D;
  const double reach = n.l1 + n.l2 * std::cos(t2), counter = n.m2 * n.l1 - n.m3 * n.l2 * std::cos(t2);
  D.D11 = n.Jy2 * sin2(t2) + n.Jy3 * sin2(t2 + t3) + n.Jz1 + n.Jz2 * cos2(t2) + n.Jz3 * cos2(t2 + t3) +
          n.m3 * reach * reach + counter * counter / n.m2;
  D.D22 = n.Jx2 + n.Jx3 + D22_mass * n.l2 * n.l2 + n.l2 * n.l2 * n.m3 * n.m3 / n.m2;
  D.D33 = D.D23 = n.Jx3;
  D.D211 = -0.5 * ((n.Jy2 - n.Jz2 - (shift_in_2 ? shift : 0)) * s22 + (n.Jy3 - n.Jz3 - (shift_in_2 ? 0 : shift)) * s23);
  D.D311 = 0.5 * (n.Jz3 - n.Jy3) * s23;
  D.D112 = -D.D211;
  D.D113 = -D.D311;
  return D;
}

/// Largest difference between the arm's torques along a motion and those by the coefficients, beside the largest torque.
template <class Formula>
double misses(const Mechanism& m, Formula&& formula) {
  VectorX from(3), to(3);
  from << -0.4, 0.3, -0.8;
  to << 0.9, 1.4, 0.5;
  const RunResult r = run(m, joint_motion({0, 1, 2}, from, to, 0.5, 21));
  double worst = 0;
  for (long k = 0; k < 21; ++k) {
    const auto q = r.joint_position.row(k), p = r.joint_velocity.row(k), a = r.joint_acceleration.row(k);
    const Coefficients D = formula(q[1], q[2]);
    const Vector3 torque(D.D11 * a[0] + 2 * D.D112 * p[0] * p[1] + 2 * D.D113 * p[0] * p[2],
                         D.D22 * a[1] + D.D23 * a[2] + D.D211 * p[0] * p[0],
                         D.D23 * a[1] + D.D33 * a[2] + D.D311 * p[0] * p[0]);
    for (int j = 0; j < 3; ++j) worst = std::max(worst, std::abs(torque[j] - r.torque(k, j)));
  }
  return worst / r.torque.leftCols(3).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("P1 eq. 31: D22 has m3 l2^2, and m3 l2^2 (1 + m3/m2) stands under sin 2 theta2") {
  std::mt19937 random(31);
  for (int trial = 0; trial < 10; ++trial) {
    const Numbers n = draw_numbers(random);
    const Mechanism m = arm(n);
    CHECK(misses(m, [&](double t2, double t3) { return eq31(n, t2, t3, n.m3, true); }) < 1e-11);
    CHECK(misses(m, [&](double t2, double t3) { return eq31(n, t2, t3, n.m2, true); }) > 1e-3);
    CHECK(misses(m, [&](double t2, double t3) { return eq31(n, t2, t3, n.m3, false); }) > 1e-3);
  }
}

namespace {

constexpr double rotor_mass = 0.5;  ///< of each, which P1 counts into link 2's

/// Two rotors on link 2 whose inertias across their axes differ, geared to joint 3 by 1 and β: P1's discs before eq. 37.
Mechanism arm_with_rotors(const Numbers& n) {
  Mechanism m = arm(n);
  const Vector3 O = Vector3::Zero(), x = Vector3::UnitX();
  add_body(m, rotor_mass, O, diagonal(n.J4x, n.J4y, n.J4z));
  add_body(m, rotor_mass, O, diagonal(n.J5x, n.J5y, n.J5z));
  const int fourth = add_joint(m, JointType::revolute, 2, O, 4, O, x),
            fifth = add_joint(m, JointType::revolute, 2, O, 5, O, x);
  m.couplings = {{fourth, 2, 1, 0}, {fifth, 2, n.ratio, 0}};
  return m;
}

Coefficients eq36(const Numbers& n, double t2, double t3) {
  const double u = t2 + t3, v = t2 + n.ratio * t3, b = n.ratio;
  Coefficients D = eq31(n, t2, t3, n.m3, true);
  D.D11 += 2 * rotor_mass * n.l1 * n.l1 + n.J4y * sin2(u) + n.J5y * sin2(v) + n.J4z * cos2(u) + n.J5z * cos2(v);
  D.D22 += n.J4x + n.J5x;
  D.D33 += n.J4x + n.J5x * b * b;
  D.D23 += n.J4x + n.J5x * b;
  const double four = 0.5 * (n.J4y - n.J4z) * std::sin(2 * u), five = 0.5 * (n.J5y - n.J5z) * std::sin(2 * v);
  D.D112 += four + five;
  D.D113 += four + b * five;
  D.D211 -= four + five;
  D.D311 -= four + b * five;
  return D;
}

/// D'11's angles and the last four coefficients as printed.
Coefficients eq36_printed(const Numbers& n, double t2, double t3, bool angles) {
  const Coefficients statics = eq31(n, t2, t3, n.m3, true);
  const double b = n.ratio;
  Coefficients D = eq36(n, t2, t3);
  if (angles) {
    const double u = 2 * t2, v = (b + 1) * t2;
    D.D11 = statics.D11 + 2 * rotor_mass * n.l1 * n.l1 + n.J4y * sin2(u) + n.J5y * sin2(v) + n.J4z * cos2(u) +
            n.J5z * cos2(v);
  } else {
    const double quarter =
        0.25 * ((n.J4y - n.J4z) * std::sin(2 * t2 + 2 * t3) + (n.J5y - n.J5z) * std::sin(2 * b * t2 + 2 * t3));
    D.D112 = statics.D112 + quarter;
    D.D113 = statics.D113 + quarter;
    D.D211 = statics.D211;
    D.D311 = statics.D311;
  }
  return D;
}

}  // namespace

TEST_CASE("P1 eq. 36: discs turn by theta2 + theta3 and theta2 + beta theta3, and change D'211 and D'311 too") {
  std::mt19937 random(36);
  for (int trial = 0; trial < 10; ++trial) {
    Numbers n = draw_numbers(random);
    n.ratio = draw(random, -3, -1);
    n.J4x = draw(random, 0.5, 0.9), n.J4y = draw(random, 0.8, 1.2), n.J4z = draw(random, 0.4, 0.7);
    n.J5x = draw(random, 0.5, 0.9), n.J5y = draw(random, 0.8, 1.2), n.J5z = draw(random, 0.4, 0.7);
    const Mechanism m = arm_with_rotors(n);
    CHECK(misses(m, [&](double t2, double t3) { return eq36(n, t2, t3); }) < 1e-11);
    CHECK(misses(m, [&](double t2, double t3) { return eq36_printed(n, t2, t3, true); }) > 1e-3);
    CHECK(misses(m, [&](double t2, double t3) { return eq36_printed(n, t2, t3, false); }) > 1e-3);
  }
}

}  // namespace errata_p1_test
