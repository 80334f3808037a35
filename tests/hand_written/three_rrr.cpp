#include "yardsticks.hpp"

#include <cmath>
#include <numbers>

namespace balance::bench {

namespace {

Plane operator+(Plane a, Plane b) { return {a.x + b.x, a.y + b.y}; }
Plane operator-(Plane a, Plane b) { return {a.x - b.x, a.y - b.y}; }
Plane operator*(double k, Plane a) { return {k * a.x, k * a.y}; }
double dot(Plane a, Plane b) { return a.x * b.x + a.y * b.y; }
double cross(Plane a, Plane b) { return a.x * b.y - a.y * b.x; }
Plane normal(Plane a) { return {-a.y, a.x}; }
Plane head(const Vector3& v) { return {v.x(), v.y()}; }

/// A place (x, y) in the axes of a link with direction e, and its acceleration against the link's first joint.
Plane placed(Plane e, Plane p) { return p.x * e + p.y * normal(e); }
Plane swung(Plane r, double rate, double acceleration) { return acceleration * normal(r) - (rate * rate) * r; }

}  // namespace

ThreeRrrYardstick::ThreeRrrYardstick(const Mechanism& m, const std::array<double, 3>& elbow)
    : platform_mass_(m.bodies[7].mass), mass_(0), platform_com_(head(m.bodies[7].com - m.tool->position)) {
  for (int i = 0; i < 3; ++i) {
    const auto link = [&](int body, int next) {
      const Body& b = m.bodies[body];
      return Link{m.joints[next].point_first.x(), b.mass, b.inertia(2, 2), head(b.com)};
    };
    const Joint *A = &m.joints[3 * i], *C = &m.joints[3 * i + 2];
    legs_[i] = {head(A->point_first), head(C->point_second - m.tool->position), elbow[i], link(1 + 2 * i, 3 * i + 1),
                link(2 + 2 * i, 3 * i + 2)};
  }
  for (const Body& body : m.bodies) mass_ += body.mass;
}

void ThreeRrrYardstick::move(const Leg& leg, const Platform& platform, ThreeRrrMoment::Leg& m) {
  const double l1 = leg.crank.length, l2 = leg.coupler.length;
  // B on the circles about A and C
  const Plane r = platform.position + leg.C - leg.A;
  const double inverse = 1 / dot(r, r), along = (0.5 / l1) * (1 + (l1 * l1 - l2 * l2) * inverse);
  m.crank = along * r + (leg.elbow * std::sqrt(inverse - along * along)) * normal(r);
  m.coupler = (1 / l2) * (r - l1 * m.crank);
  // ω₁ l₁ n₁ + ω₂ l₂ n₂ = the velocity of C, and so for accelerations
  const double sine = 1 / cross(m.crank, m.coupler), first = sine / l1, second = -sine / l2;
  m.crank_rate = first * dot(platform.velocity, m.coupler);
  m.coupler_rate = second * dot(platform.velocity, m.crank);
  const Plane rest = platform.acceleration + (m.crank_rate * m.crank_rate * l1) * m.crank +
                     (m.coupler_rate * m.coupler_rate * l2) * m.coupler;
  m.crank_acceleration = first * dot(rest, m.coupler);
  m.coupler_acceleration = second * dot(rest, m.crank);
}

void ThreeRrrYardstick::balance_forces(const Platform& platform, ThreeRrrMoment& m) const {
  Plane crank_force[3], coupler_force[3];  // mass times acceleration
  double crank_moment[3];                  // about A
  const Plane platform_force = platform_mass_ * platform.acceleration;
  Plane rest = platform_force;  // what the axial forces of the couplers give the platform
  double moment = cross(platform_com_, platform_force);
  double arm[3], normal_force[3];
  m.com = platform_mass_ * (platform.position + platform_com_);
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = legs_[i];
    const ThreeRrrMoment::Leg& l = m.legs[i];
    const Plane r1 = placed(l.crank, leg.crank.com), r2 = placed(l.coupler, leg.coupler.com),
                B = leg.crank.length * l.crank;
    crank_force[i] = leg.crank.mass * swung(r1, l.crank_rate, l.crank_acceleration);
    crank_moment[i] = leg.crank.inertia * l.crank_acceleration + cross(r1, crank_force[i]);
    coupler_force[i] = leg.coupler.mass * (swung(B, l.crank_rate, l.crank_acceleration) +
                                           swung(r2, l.coupler_rate, l.coupler_acceleration));
    normal_force[i] =
        -(leg.coupler.inertia * l.coupler_acceleration + cross(r2, coupler_force[i])) / leg.coupler.length;
    const Plane across = normal_force[i] * normal(l.coupler);
    rest = rest - across;
    moment -= cross(leg.C, across);
    arm[i] = cross(leg.C, l.coupler);
    m.com = m.com + leg.crank.mass * (leg.A + r1) + leg.coupler.mass * (leg.A + B + r2);
  }
  m.com = (1 / mass_) * m.com;
  // Σ Xᵢ eᵢ = rest, Σ Xᵢ armᵢ = moment
  const Plane e0 = m.legs[0].coupler, e1 = m.legs[1].coupler, e2 = m.legs[2].coupler;
  const double c0 = cross(e1, e2), c1 = cross(e2, e0), c2 = cross(e0, e1);
  const double inverse = 1 / (arm[0] * c0 + arm[1] * c1 + arm[2] * c2);
  const double axial[3] = {inverse * (moment * c0 + arm[1] * cross(e2, rest) + arm[2] * cross(rest, e1)),
                           inverse * (moment * c1 + arm[2] * cross(e0, rest) + arm[0] * cross(rest, e2)),
                           inverse * (moment * c2 + arm[0] * cross(e1, rest) + arm[1] * cross(rest, e0))};
  m.shaking_force = {};
  m.shaking_moment = 0;
  for (int i = 0; i < 3; ++i) {
    ThreeRrrMoment::Leg& l = m.legs[i];
    l.force_C = axial[i] * l.coupler + normal_force[i] * normal(l.coupler);
    l.force_B = l.force_C + coupler_force[i];
    l.force_A = l.force_B + crank_force[i];
    l.torque = crank_moment[i] + legs_[i].crank.length * cross(l.crank, l.force_B);
    l.power = l.torque * l.crank_rate;
    m.shaking_force = m.shaking_force + l.force_A;
    m.shaking_moment += cross(legs_[i].A, l.force_A) + l.torque;
  }
}

ThreeRrrMoment ThreeRrrYardstick::at(double s, Plane from, Plane to, double duration) const {
  constexpr double turn = 2 * std::numbers::pi;
  double sine, cosine;
  ::sincos(turn * s, &sine, &cosine);
  const Plane way = to - from;
  const Platform platform = {from + (s - sine / turn) * way, ((1 - cosine) / duration) * way,
                             (turn * sine / (duration * duration)) * way};
  ThreeRrrMoment m;
  m.tool = platform.position;
  for (int i = 0; i < 3; ++i) move(legs_[i], platform, m.legs[i]);
  balance_forces(platform, m);
  return m;
}

}  // namespace balance::bench
