#include "fixtures.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace balance::bench {

namespace {

Body link(const std::string& name, double mass, const Vector3& com, const Matrix3& inertia) {
  Body body;
  body.name = name;
  body.mass = mass;
  body.com = com;
  body.inertia = inertia;
  return body;
}

Matrix3 polar(double J) { return Vector3(0, 0, J).asDiagonal(); }

int revolute(Mechanism& mechanism, const std::string& name, int first, const Vector3& P, int second, const Vector3& Q) {
  Joint joint;
  joint.name = name;
  joint.first = first;
  joint.second = second;
  joint.point_first = P;
  joint.point_second = Q;
  mechanism.joints.push_back(joint);
  return static_cast<int>(mechanism.joints.size()) - 1;
}

}  // namespace

Mechanism three_rrr() {
  Mechanism m;
  m.bodies.emplace_back();
  m.bodies[0].name = "ground";
  const double l = 0.18, h = 0.15 * std::sqrt(3) / 2;
  const Vector3 A[3] = {{0.21651, -0.125, 0}, {-0.21651, -0.125, 0}, {0, 0.25, 0}};
  const Vector3 C[3] = {{0.15, 0, 0}, {0, 0, 0}, {0.075, h, 0}};
  const Vector3 H(0.075, h / 3, 0);
  for (int leg = 0; leg < 3; ++leg) {
    m.bodies.push_back(link("crank" + std::to_string(leg + 1), 1, {l / 2, 0, 0}, polar(0.0028)));
    m.bodies.push_back(link("coupler" + std::to_string(leg + 1), 1, {l / 2, 0, 0}, polar(0.0028)));
  }
  m.bodies.push_back(link("platform", 3, H, polar(0.0056)));
  for (int leg = 0; leg < 3; ++leg) {
    const std::string n = std::to_string(leg + 1);
    m.actuators.push_back(revolute(m, "A" + n, 0, A[leg], 1 + 2 * leg, Vector3::Zero()));
    revolute(m, "B" + n, 1 + 2 * leg, {l, 0, 0}, 2 + 2 * leg, Vector3::Zero());
    revolute(m, "C" + n, 2 + 2 * leg, {l, 0, 0}, 7, C[leg]);
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  m.tool = Tool{7, "H", H};
  m.assembly = {{1, -1.6}, {4, -2.8}, {7, -1.7}};
  return m;
}

Trajectory three_rrr_cycloid(long samples) {
  Trajectory t;
  t.name = "cycloid";
  t.duration = 0.1;
  t.samples = samples;
  t.from.tool = Vector3(-0.1, -0.05, 0);
  t.to.tool = Vector3(0.1, 0.05, 0);
  t.from.angle = t.to.angle = 0;
  return t;
}

Mechanism planar_rrr() {
  Mechanism m;
  m.gravity = {0, -9.81, 0};
  m.bodies.emplace_back();
  m.bodies[0].name = "ground";
  m.bodies.push_back(link("link1", 2, {0.2, 0.01, 0}, polar(0.02)));
  m.bodies.push_back(link("link2", 1.5, {0.18, 0, 0}, polar(0.015)));
  m.bodies.push_back(link("link3", 1, {0.1, -0.02, 0}, polar(0.01)));
  const double lengths[3] = {0, 0.5, 0.4};
  for (int j = 0; j < 3; ++j)
    m.actuators.push_back(revolute(m, "J" + std::to_string(j + 1), j, {lengths[j], 0, 0}, j + 1, Vector3::Zero()));
  m.coordinates = list_coordinates(m.space, m.joints);
  return m;
}

Trajectory planar_rrr_cycloid(long samples) {
  Trajectory t;
  t.name = "cycloid";
  t.drive = DriveKind::joints;
  t.samples = samples;
  t.from.joints = {{0, 0.1}, {1, 0.4}, {2, -0.3}};
  t.to.joints = {{0, 1.3}, {1, -0.9}, {2, 0.8}};
  return t;
}

Mechanism seven_joint_arm() {
  Mechanism m;
  m.space = SpaceKind::spatial;
  m.gravity = {0, 0, -9.81};
  m.bodies.emplace_back();
  m.bodies[0].name = "ground";
  for (int j = 0; j < 7; ++j) {
    Matrix3 inertia;
    inertia << 0.03, 0.001, -0.002, 0.001, 0.025, 0.0005, -0.002, 0.0005, 0.01;
    m.bodies.push_back(link("link" + std::to_string(j + 1), 4 - 0.4 * j, {0.01, -0.02, 0.1}, inertia));
    const int k = revolute(m, "J" + std::to_string(j + 1), j, j == 0 ? Vector3(0, 0, 0.3) : Vector3(0, 0.02, 0.2),
                           j + 1, Vector3::Zero());
    m.joints[k].rotation = rotation_from_rpy({(j % 2 ? 0.5 : -0.5) * std::numbers::pi, 0, 0});
    m.joints[k].axis = m.joints[k].rotation.col(2);
    m.actuators.push_back(k);
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  return m;
}

}  // namespace balance::bench
