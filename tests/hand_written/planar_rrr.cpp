#include "yardsticks.hpp"

#include <cmath>

namespace balance::bench {

PlanarRrrYardstick::PlanarRrrYardstick(const Mechanism& m) : gravity_{m.gravity.x(), m.gravity.y()} {
  for (int j = 0; j < 3; ++j) {
    const Body& body = m.bodies[j + 1];
    const double length = j < 2 ? m.joints[j + 1].point_first.x() : 0;
    links_[j] = {length, body.mass, body.inertia(2, 2), {body.com.x(), body.com.y()}};
  }
}

void PlanarRrrYardstick::torques(const double* q, const double* dq, const double* ddq, double* torque) const {
  double angle = 0, rate = 0, acceleration = 0;
  Plane a = {-gravity_.x, -gravity_.y};  // of the joint
  Plane u[3], force[3];
  double moment[3];
  for (int j = 0; j < 3; ++j) {
    const Link& link = links_[j];
    angle += q[j], rate += dq[j], acceleration += ddq[j];
    double s, c;
    ::sincos(angle, &s, &c);
    u[j] = {c, s};
    const double square = rate * rate;
    const Plane r = {c * link.com.x - s * link.com.y, s * link.com.x + c * link.com.y};
    force[j] = {link.mass * (a.x - acceleration * r.y - square * r.x),
                link.mass * (a.y + acceleration * r.x - square * r.y)};
    moment[j] = link.inertia * acceleration + r.x * force[j].y - r.y * force[j].x;
    a.x -= link.length * (acceleration * s + square * c);
    a.y += link.length * (acceleration * c - square * s);
  }
  Plane f = force[2];
  double m = torque[2] = moment[2];
  for (int j = 1; j >= 0; --j) {
    m += moment[j] + links_[j].length * (u[j].x * f.y - u[j].y * f.x);
    f.x += force[j].x, f.y += force[j].y;
    torque[j] = m;
  }
}

}  // namespace balance::bench
