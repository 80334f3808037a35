#include "yardsticks.hpp"

#include <cmath>

namespace balance::bench {

namespace {

struct Vec {
  double x = 0, y = 0, z = 0;
};
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator*(double k, Vec a) { return {k * a.x, k * a.y, k * a.z}; }
Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Vec vec(const double* v) { return {v[0], v[1], v[2]}; }
Vec times(const double (&M)[3][3], Vec v) {
  return {M[0][0] * v.x + M[0][1] * v.y + M[0][2] * v.z, M[1][0] * v.x + M[1][1] * v.y + M[1][2] * v.z,
          M[2][0] * v.x + M[2][1] * v.y + M[2][2] * v.z};
}
Vec transposed_times(const double (&M)[3][3], Vec v) {
  return {M[0][0] * v.x + M[1][0] * v.y + M[2][0] * v.z, M[0][1] * v.x + M[1][1] * v.y + M[2][1] * v.z,
          M[0][2] * v.x + M[1][2] * v.y + M[2][2] * v.z};
}
/// α × r + ω × (ω × r)
Vec swung(Vec w, Vec alpha, Vec r) { return cross(alpha, r) + cross(w, cross(w, r)); }

}  // namespace

SevenJointYardstick::SevenJointYardstick(const Mechanism& m) : gravity_{m.gravity.x(), m.gravity.y(), m.gravity.z()} {
  for (int j = 0; j < 7; ++j) {
    const Body& body = m.bodies[j + 1];
    const Vector3 c = body.com;
    const Matrix3 about_joint = body.inertia + body.mass * (c.squaredNorm() * Matrix3::Identity() - c * c.transpose());
    links_[j].mass = body.mass;
    for (int i = 0; i < 3; ++i) {
      links_[j].p[i] = m.joints[j].point_first[i];
      links_[j].moment[i] = body.mass * c[i];
      for (int k = 0; k < 3; ++k)
        links_[j].R[i][k] = m.joints[j].rotation(i, k), links_[j].inertia[i][k] = about_joint(i, k);
    }
  }
}

void SevenJointYardstick::torques(const double* q, const double* dq, const double* ddq, double* torque) const {
  double R[7][3][3];
  Vec force[7], moment[7], w, alpha, a = -1.0 * vec(gravity_);
  for (int j = 0; j < 7; ++j) {
    const Link& link = links_[j];
    double s, c;
    ::sincos(q[j], &s, &c);
    for (int i = 0; i < 3; ++i) {
      R[j][i][0] = c * link.R[i][0] + s * link.R[i][1];
      R[j][i][1] = c * link.R[i][1] - s * link.R[i][0];
      R[j][i][2] = link.R[i][2];
    }
    a = transposed_times(R[j], a + swung(w, alpha, vec(link.p)));
    w = transposed_times(R[j], w);
    alpha = transposed_times(R[j], alpha);
    w.z += dq[j];
    alpha = alpha + Vec{w.y * dq[j], -w.x * dq[j], ddq[j]};
    const Vec h = vec(link.moment);
    force[j] = link.mass * a + swung(w, alpha, h);
    moment[j] = times(link.inertia, alpha) + cross(w, times(link.inertia, w)) + cross(h, a);
  }
  torque[6] = moment[6].z;
  for (int j = 6; j > 0; --j) {
    const Vec f = times(R[j], force[j]);
    force[j - 1] = force[j - 1] + f;
    moment[j - 1] = moment[j - 1] + times(R[j], moment[j]) + cross(vec(links_[j].p), f);
    torque[j - 1] = moment[j - 1].z;
  }
}

}  // namespace balance::bench
