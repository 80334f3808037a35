// Serial arms of P1 (balanced by mass distribution and discs) and P0 (by counterweights): torques in closed form.

#include "published.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace published;
using balance::JointType;
using balance::SpaceKind;

namespace {

/// torque_i = k_i θ_i'' at every sample, to 1e-10 of what the parts that must cancel amount to.
void check_decoupled(const RunResult& r, const VectorX& k, double weight_torque) {
  const double scale = weight_torque + (r.joint_acceleration.leftCols(k.size()) * k.asDiagonal()).cwiseAbs().maxCoeff();
  for (long i = 0; i < r.time.size(); ++i)
    for (long j = 0; j < k.size(); ++j)
      CHECK(std::abs(r.torque(i, j) - k[j] * r.joint_acceleration(i, j)) < 1e-10 * scale);
}

Trajectory random_motion(const Mechanism& m, std::mt19937& random) {
  VectorX from(3), to(3);
  for (int j = 0; j < 3; ++j) from[j] = draw(random, -2, 2), to[j] = draw(random, -2, 2);
  return joint_motion(m.actuators, from, to, 0.7, 31);
}

Matrix3 diagonal(double x, double y, double z) { return Vector3(x, y, z).asDiagonal(); }

}  // namespace

TEST_CASE("P1 section 3.1: a planar RRR arm that meets eq. 20 and 26 has the torques of eq. 27 and 28") {
  // The discs' own masses, which P1 counts into the links', are explicit: zero in the first trial, which is eq. 28 as printed.
  std::mt19937 random(31);
  for (int trial = 0; trial < 20; ++trial) {
    const auto any = [&] { return draw(random, 0.2, 2); };
    const double l1 = any(), l2 = any(), l3 = any(), m1 = any(), m2 = any(), m3 = any();
    const double J1 = any(), J2 = any(), J3 = any(), J4 = any(), J5 = any(), J6 = any(), J7 = any();
    const bool printed = trial == 0;
    const double m4 = printed ? 0 : any(), m6 = printed ? 0 : any(), m7 = printed ? 0 : any();
    const double ride = m2 + m3 + m6 + m7;
    const double all = J2 + J3 + J4 + J6 + J7 + m3 * l2 * l2 + m3 * m3 * l2 * l2 / m2;
    Mechanism m = empty(SpaceKind::planar, {draw(random, -9, 9), -9.81, 0});
    add_body(m, m1, {-l1 * ride / m1, 0, 0}, J1);
    add_body(m, m2, {-l2 * m3 / m2, 0, 0}, J2);
    add_body(m, m3, {0, 0, 0}, J3);
    const Vector3 O = Vector3::Zero(), z = Vector3::UnitZ();
    add_joint(m, JointType::revolute, 0, O, 1, O);
    add_joint(m, JointType::revolute, 1, {l1, 0, 0}, 2, O);
    add_joint(m, JointType::revolute, 2, {l2, 0, 0}, 3, O);
    add_disc(m, 1, O, z, 1, 1, m4, about_z(J4));
    add_disc(m, 1, O, z, 1, -all / J5, m4, about_z(J5));
    add_disc(m, 2, O, z, 2, 1, m6, about_z(J6));
    add_disc(m, 2, O, z, 2, -(J3 + J6) / J7, m7, about_z(J7));
    m.actuators = {0, 1, 2};
    VectorX k(3);
    k << J1 + J2 + J3 + J4 + J5 + J6 + J7 + (m2 + m6 + m7) * l1 * l1 + m3 * (l1 * l1 + l2 * l2) +
             l1 * l1 * ride * ride / m1 + l2 * l2 * m3 * m3 / m2,
        all + all * all / J5, (J3 + J6) * (J3 + J6 + J7) / J7;
    check_decoupled(run(m, random_motion(m, random)), k, 10 * (m1 + ride) * (l1 + l2 + l3));
  }
}

TEST_CASE("P1 section 3.2: a spatial RRR arm that meets eq. 30 and 37 as corrected has the torques of eq. 38 and 39") {
  std::mt19937 random(32);
  for (int trial = 0; trial < 20; ++trial) {
    const auto any = [&] { return draw(random, 0.2, 2); };
    const double l1 = any(), l2 = any(), m1 = any(), m2 = any(), m3 = any(), m4 = any(), m5 = any();
    const double Jz1 = any(), Jx2 = any(), Jz2 = any(), Jx3 = any(), Jz3 = any(), Jx4 = any(), Jx5 = any(), Jz4 = any(),
                 Jz5 = any();
    const double Jy2 = Jz2 + m3 * l2 * l2 * (1 + m3 / m2);
    const Vector3 O = Vector3::Zero(), x = Vector3::UnitX();
    Mechanism m = empty(SpaceKind::spatial, {0, 0, -9.81});
    add_body(m, m1, {0, 0, any()}, diagonal(any(), any(), Jz1));
    add_body(m, m2, {0, -l2 * m3 / m2, 0}, diagonal(Jx2, Jy2, Jz2));
    add_body(m, m3, O, diagonal(Jx3, Jz3, Jz3));
    add_joint(m, JointType::revolute, 0, O, 1, O);
    add_joint(m, JointType::revolute, 1, {0, l1, 0}, 2, O, x);
    add_joint(m, JointType::revolute, 2, {0, l2, 0}, 3, O, x);
    add_disc(m, 2, O, x, 2, 1, m4, diagonal(Jx4, Jz4, Jz4));
    add_disc(m, 2, O, x, 2, -(Jx3 + Jx4) / Jx5, m5, diagonal(Jx5, Jz5, Jz5));
    m.actuators = {0, 1, 2};
    const double bar = m3 * l2 * l2 + l2 * l2 * m3 * m3 / m2;
    VectorX k(3);
    k << Jz1 + Jz2 + Jz3 + Jz4 + Jz5 + (m2 + m4 + m5) * l1 * l1 + m3 * l1 * l1 + bar, Jx2 + Jx3 + Jx4 + Jx5 + bar,
        (Jx3 + Jx4) * (Jx3 + Jx4 + Jx5) / Jx5;
    check_decoupled(run(m, random_motion(m, random)), k, 10 * (m1 + m2 + m3) * (l1 + l2));
  }
}

TEST_CASE("P1 section 3.3: a SCARA arm that meets eq. 41 and 47 has the torques of eq. 48 and 49") {
  // The slider at distance l2 from joint 2; with l2 = 0, the first trial, the equations are those printed.
  std::mt19937 random(33);
  for (int trial = 0; trial < 20; ++trial) {
    const auto any = [&] { return draw(random, 0.2, 2); };
    const double l1 = any(), l2 = trial == 0 ? 0 : any(), m1 = any(), m2 = any(), m3 = any();
    const double J1 = any(), J2 = any(), J3 = any(), J4 = any(), J5 = any(), X = m3 * l2 * l2 * (1 + m3 / m2);
    const Vector3 O = Vector3::Zero(), z = Vector3::UnitZ();
    Mechanism m = empty(SpaceKind::spatial, {3, -9.81, 0});
    add_body(m, m1, {-l1 * (m2 + m3) / m1, 0, any()}, diagonal(any(), any(), J1));
    add_body(m, m2, {-l2 * m3 / m2, 0, any()}, diagonal(any(), any(), J2));
    add_body(m, m3, {0, 0, any()}, diagonal(any(), any(), J3));
    add_joint(m, JointType::revolute, 0, O, 1, O);
    add_joint(m, JointType::revolute, 1, {l1, 0, 0}, 2, O);
    add_joint(m, JointType::prismatic, 2, {l2, 0, 0}, 3, O);
    add_disc(m, 1, O, z, 1, 1, any(), diagonal(0.1, 0.1, J4));
    add_disc(m, 1, O, z, 1, -(J2 + J3 + J4 + X) / J5, any(), diagonal(0.2, 0.2, J5));
    m.actuators = {0, 1, 2};
    VectorX k(3);
    k << J1 + J2 + J3 + J4 + J5 + X + (m2 + m3) * l1 * l1 + l1 * l1 * (m2 + m3) * (m2 + m3) / m1,
        (J2 + J3 + J4 + X) * (J2 + J3 + J4 + J5 + X) / J5, m3;
    check_decoupled(run(m, random_motion(m, random)), k, 10 * (m1 + m2 + m3) * (l1 + l2));
  }
}

TEST_CASE("P1: the torques of the balanced arms in configs/ are constants times accelerations") {
  for (const char* file : {"planar-rrr.yaml", "spatial-rrr.yaml", "scara.yaml"})
    for (const char* name : {"cycloid", "bang-bang"}) {
      const RunResult r = run(file, name, 101);
      const long n = r.torque.cols();
      // constants by least squares; what is left over must be round-off
      for (long j = 0; j < n; ++j) {
        const VectorX u = r.torque.col(j), a = r.joint_acceleration.col(j);
        const double k = u.dot(a) / a.squaredNorm();
        CHECK(k > 0);
        CHECK_MESSAGE((u - k * a).cwiseAbs().maxCoeff() < 1e-10 * u.cwiseAbs().maxCoeff(),
                      file << " " << name << " " << j);
      }
    }
}

namespace {

/// P0 section 3.2: masses of link i at γ a_i, payload at the tip, counterweights at −γ a_i.
struct RR {
  double a1, a2, m1, m2, payload, cw1, cw2, g1, g2, g3, g4, I1, I2, g = 9.81;

  explicit RR(std::mt19937& random) {
    for (double* x : {&a1, &a2, &m1, &m2, &payload, &cw1, &cw2, &g1, &g2, &g3, &g4, &I1, &I2})
      *x = draw(random, 0.2, 1.5);
  }
  void balance_weights() {  // eq. 95
    cw2 = (m2 * g2 + payload) / g4;
    cw1 = (m1 * g1 + m2 + payload + cw2) / g3;
  }
  Mechanism mechanism() const {
    Mechanism m = empty(SpaceKind::planar, {0, -g, 0});
    add_body(m, m1, {g1 * a1, 0, 0}, I1);
    add_body(m, m2, {g2 * a2, 0, 0}, I2);
    add_joint(m, JointType::revolute, 0, Vector3::Zero(), 1, Vector3::Zero());
    add_joint(m, JointType::revolute, 1, {a1, 0, 0}, 2, Vector3::Zero());
    m.attachments.push_back({"payload", balance::AttachmentKind::payload, 2, {a2, 0, 0}, payload, Matrix3::Zero()});
    m.attachments.push_back({"cw1", balance::AttachmentKind::counterweight, 1, {-g3 * a1, 0, 0}, cw1, Matrix3::Zero()});
    m.attachments.push_back({"cw2", balance::AttachmentKind::counterweight, 2, {-g4 * a2, 0, 0}, cw2, Matrix3::Zero()});
    m.actuators = {0, 1};
    return m;
  }
  /// eq. 90, 92–94 with the sign of eq. 14 as corrected: u = M q'' − G + weight.
  Eigen::Vector2d torque(double q1, double q2, double p1, double p2, double w1, double w2) const {
    const double i1 = a2 * a2 * (m2 * g2 * g2 + payload + cw2 * g4 * g4) + I2;
    const double i2 = a1 * a1 * (m1 * g1 * g1 + cw1 * g3 * g3 + m2 + payload + cw2) + I1;
    const double arm = m2 * g2 - cw2 * g4 + payload, i3 = a1 * a2 * arm;
    const double mu1 = g * a1 * (m1 * g1 - cw1 * g3 + m2 + payload + cw2), mu2 = g * a2 * arm;
    const double c = std::cos(q2), s = std::sin(q2);
    const Eigen::Vector2d G(i3 * s * p2 * (p2 + 2 * p1), -i3 * p1 * p1 * s);
    const Eigen::Vector2d weight(mu1 * std::cos(q1) + mu2 * std::cos(q1 + q2), mu2 * std::cos(q1 + q2));
    Eigen::Matrix2d M;
    M << i1 + i2 + 2 * c * i3, i1 + c * i3, i1 + c * i3, i1;
    return M * Eigen::Vector2d(w1, w2) - G + weight;
  }
};

}  // namespace

TEST_CASE("P0 section 3.2: the RR arm's torques are those of eq. 90 and 92 to 94") {
  std::mt19937 random(90);
  for (int trial = 0; trial < 20; ++trial) {
    RR arm(random);
    if (trial % 2) arm.balance_weights();
    const Mechanism m = arm.mechanism();
    VectorX from(2), to(2);
    for (int j = 0; j < 2; ++j) from[j] = draw(random, -3, 3), to[j] = draw(random, -3, 3);
    const RunResult r = run(m, joint_motion({0, 1}, from, to, 0.6, 21));
    for (long k = 0; k < 21; ++k) {
      const auto q = r.joint_position.row(k), p = r.joint_velocity.row(k), w = r.joint_acceleration.row(k);
      const Eigen::Vector2d want = arm.torque(q[0], q[1], p[0], p[1], w[0], w[1]);
      const double scale = r.torque.cwiseAbs().maxCoeff();
      CHECK((r.torque.row(k).transpose() - want).norm() < 1e-12 * scale);
    }
  }
}

TEST_CASE("P0 section 3.2: counterweights by eq. 95 leave a constant matrix of inertia and nothing else") {
  std::mt19937 random(95);
  for (int trial = 0; trial < 10; ++trial) {
    RR arm(random);
    arm.balance_weights();
    VectorX from(2), to(2);
    from << -1, 0.3, to << 1.2, 2;
    const RunResult r = run(arm.mechanism(), joint_motion({0, 1}, from, to, 0.6, 41));
    Eigen::Matrix2d M;  // torques for unit accelerations at rest, from anywhere: eq. 97
    M.col(0) = arm.torque(0, 0.5, 0, 0, 1, 0) - arm.torque(0, 0.5, 0, 0, 0, 0);
    M.col(1) = arm.torque(0, 0.5, 0, 0, 0, 1) - arm.torque(0, 0.5, 0, 0, 0, 0);
    const auto want = (r.joint_acceleration * M.transpose()).eval();
    CHECK((r.torque - want).cwiseAbs().maxCoeff() < 1e-11 * r.torque.cwiseAbs().maxCoeff());
  }
}
