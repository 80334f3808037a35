// Belts over several joints: discs and coupled joints that follow sums of coordinates.

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

using namespace balance;
using namespace balance::model;

namespace {

class BeltMaker {
 public:
  BeltMaker(SpaceKind space, std::uint32_t seed) : random_(seed), planar_(space == SpaceKind::planar) {
    arm_.space = space;
    arm_.gravity = 9 * place();
    arm_.bodies.emplace_back();
    arm_.bodies[0].name = "ground";
    for (int b = 1; b <= 3; ++b) {
      Body body;
      body.name = "link" + std::to_string(b);
      body.mass = number(0.5, 2), body.com = 0.3 * place(), body.inertia = inertia();
      arm_.bodies.push_back(body);
      Joint joint;
      joint.name = "J" + std::to_string(b);
      joint.first = b - 1, joint.second = b;
      joint.point_first = place(), joint.point_second = 0.2 * place();
      joint.axis = planar_ ? Vector3(Vector3::UnitZ()) : Vector3(place().normalized());
      arm_.joints.push_back(joint);
    }
    arm_.coordinates = list_coordinates(space, arm_.joints);
    arm_.actuators = {0, 1, 2};
  }

  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3 place() { return {number(-1, 1), number(-1, 1), planar_ ? 0 : number(-1, 1)}; }
  Matrix3 inertia() {
    const Vector3 second(number(0.01, 0.1), number(0.01, 0.1), number(0.01, 0.1));
    const double polar = second.x() + second.y();
    if (planar_) return Vector3(0, 0, polar).asDiagonal();
    return Vector3(second.y() + second.z(), second.x() + second.z(), polar).asDiagonal();
  }
  VectorX state() {
    return VectorX::NullaryExpr(3, [&] { return number(-2, 2); });
  }
  Mechanism& arm() { return arm_; }

 private:
  std::mt19937 random_;
  bool planar_;
  Mechanism arm_;
};

/// Turns and slides of sums of two others.
Coupling belt(double first, double second, double offset) {
  return {2, CoordinateCombination(std::vector<CoordinateTerm>{{0, first}, {1, second}}), 1, offset};
}

double off(const VectorX& a, const VectorX& b) { return (a - b).norm() / (a.norm() + b.norm()); }

/// Some ten recursions of numbers of the order one.
constexpr double rounding = 1e-12;

}  // namespace

TEST_CASE("a rotor is worth the same on either side of a joint, if a belt over that joint turns it as fast") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
      BeltMaker make(space, seed);
      Mechanism beyond = make.arm();
      const Joint& joint = beyond.joints[1];
      const double ratio = make.number(-3, 3);
      Disc disc{"d", joint.second, joint.point_second, joint.axis, 2, ratio, 0.4, make.inertia()};
      beyond.discs = {disc};
      Mechanism before = beyond;
      before.discs[0].body = joint.first, before.discs[0].position = joint.point_first;
      before.discs[0].follows = CoordinateCombination(std::vector<CoordinateTerm>{{1, 1 / ratio}, {2, 1}});
      const VectorX q = make.state(), dq = make.state(), ddq = make.state();
      InverseDynamics one(beyond), other(before);
      const auto a = one.at(q, dq, ddq), b = other.at(q, dq, ddq);
      REQUIRE((a && b));
      CHECK(off(a.value.effort, b.value.effort) < rounding);
      CHECK(off(a.value.shaking_force, b.value.shaking_force) < rounding);
      CHECK(off(a.value.shaking_moment, b.value.shaking_moment) < rounding);
      CHECK(std::abs(a.value.kinetic_energy / b.value.kinetic_energy - 1) < rounding);
    }
}

TEST_CASE("a joint that follows two others loads their motors with its own effort times the ratios") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
      BeltMaker make(space, seed);
      const double r0 = make.number(0.5, 2), r1 = make.number(-2, -0.5), offset = make.number(-1, 1);
      Mechanism tied = make.arm();
      tied.couplings = {belt(r0, r1, offset)};
      tied.actuators = {0, 1};
      Mechanism belt_motor = tied;
      belt_motor.actuators = {0, 2};
      VectorX q = make.state(), dq = make.state(), ddq = make.state();
      q[2] = r0 * q[0] + r1 * q[1] + offset, dq[2] = r0 * dq[0] + r1 * dq[1], ddq[2] = r0 * ddq[0] + r1 * ddq[1];
      const auto free = InverseDynamics(make.arm()).at(q, dq, ddq);
      InverseDynamics coupled(tied, {.independent = {"J1", "J2"}}), driven(belt_motor, {.independent = {"J1", "J3"}});
      const auto pick = [](const VectorX& all, int one, int other) { return VectorX(Vector2(all[one], all[other])); };
      const auto led = coupled.at(pick(q, 0, 1), pick(dq, 0, 1), pick(ddq, 0, 1));
      const auto pulled = driven.at(pick(q, 0, 2), pick(dq, 0, 2), pick(ddq, 0, 2));
      REQUIRE((free && led && pulled));
      const VectorX& u = free.value.effort;
      const Vector2 all(u[0] + r0 * u[2], u[1] + r1 * u[2]);
      CHECK(off(led.value.effort, all) < rounding);
      // the belt's motor alone moves joint 2, and takes its share along joint 1
      CHECK(off(pulled.value.effort, Vector2(all[0] - r0 / r1 * all[1], all[1] / r1)) < rounding);
      CHECK(off(pulled.value.position, q) < rounding);
      CHECK(off(led.value.shaking_force, free.value.shaking_force) < rounding);
    }
}

TEST_CASE("forward dynamics with belts gives back the accelerations whose efforts inverse dynamics found") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
      BeltMaker make(space, seed);
      Mechanism arm = make.arm();
      const double r0 = make.number(0.5, 2), r1 = make.number(-2, -0.5);
      arm.couplings = {belt(r0, r1, 0.3)};
      arm.actuators = {0, 2};
      arm.discs = {{"d", 3, 0.2 * make.place(), arm.joints[2].axis,
                    CoordinateCombination(std::vector<CoordinateTerm>{{0, 0.7}, {2, -1.2}}), 2, 0.3, make.inertia()}};
      arm.friction = {{2, 0.4, 0, {}}};
      const VectorX q = make.state(), dq = make.state(), ddq = make.state();
      InverseDynamics inverse(arm, {.independent = {"J1", "J3"}});
      const auto found = inverse.at(q.head(2), dq.head(2), ddq.head(2));
      REQUIRE(found);
      dynamics::ForwardDynamics forward(arm, {.preferred = arm.actuators});
      REQUIRE(forward.set_state(0, found.value.position, found.value.velocity).status == MotionStatus::done);
      CHECK(off(forward.acceleration(found.value.effort), found.value.acceleration) < 10 * rounding);
    }
}
