// Dry friction with true rest, against closed forms.

#include "plant_cases.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace stiction_test {

using namespace plants;

namespace {

constexpr double pi = std::numbers::pi;

}  // namespace

TEST_CASE("a block slides until its energy is spent, stands, and starts where the force exceeds static friction (A4)") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> part(0.2, 1);
  for (int turn = 0; turn < 10; ++turn) {
    const double c = 5 * part(random), s = c * (1 + part(random)), v = 2 * part(random), m = 2;
    CAPTURE(c);
    CAPTURE(s);
    CAPTURE(v);
    const Mechanism mechanism = block(c, s, 0);
    Plant plant = started(mechanism, values({0.1}), values({v}));
    const double stop = m * v / c;
    move(plant, 0.5 * stop, values({0}));
    CHECK(plant.velocity()[0] == doctest::Approx(v / 2).epsilon(1e-12));
    move(plant, stop + 1, values({0}));
    const double place = 0.1 + m * v * v / (2 * c);
    CHECK(plant.position()[0] == doctest::Approx(place).epsilon(1e-10));
    CHECK(plant.velocity()[0] == 0);
    const double stands = plant.position()[0];
    for (const double part_of : {0.5, -0.9, 0.999999}) {
      move(plant, plant.time() + 3, values({part_of * s}));
      CHECK(plant.position()[0] == stands);
      CHECK(plant.velocity()[0] == 0);
      CHECK(plant.observe(values({part_of * s})).friction_power == 0);
      CHECK(std::abs(plant.observe(values({part_of * s})).shaking_force.x()) < 1e-12 * s);
    }
    CHECK(std::abs(plant.acceleration(values({1.001 * s}))[0] - (1.001 * s - c) / m) < 1e-12 * s);
    move(plant, plant.time() + 1, values({1.001 * s}));
    CHECK(plant.velocity()[0] == doctest::Approx((1.001 * s - c) / m).epsilon(1e-12));
    move(plant, plant.time() + 1, values({0.5 * (c + s)}));  // less than static friction keeps what moves moving
    CHECK(plant.velocity()[0] == doctest::Approx(((1.001 * s - c) + 0.5 * (s - c)) / m).epsilon(1e-12));
  }
}

TEST_CASE("where friction differs between directions, a block stands and slides by each one's own") {
  const double forth = 3, back = 1.2, forth_at_rest = 4, back_at_rest = 1.5, m = 2;
  Mechanism mechanism = block(forth, forth_at_rest, 0);
  mechanism.friction[0].coulomb_backward = back;
  mechanism.friction[0].at_rest_backward = back_at_rest;
  Plant plant = started(mechanism, values({0}), values({0}));
  for (const double held : {0.999999 * forth_at_rest, -0.999999 * back_at_rest, 0.0}) {
    move(plant, plant.time() + 1, values({held}));
    CHECK(plant.position()[0] == 0);
  }
  // round-off of a sum of two terms
  CHECK(std::abs(plant.acceleration(values({5}))[0] - (5 - forth) / m) < 1e-14);
  CHECK(std::abs(plant.acceleration(values({-2}))[0] + (2 - back) / m) < 1e-14);
  for (const double v : {1.5, -1.5}) {
    Plant thrown = started(mechanism, values({0}), values({v}));
    const double resists = v > 0 ? forth : back;
    move(thrown, 2 * m * std::abs(v) / resists, values({0}));
    CHECK(thrown.velocity()[0] == 0);
    CHECK(thrown.position()[0] == doctest::Approx(m * v * std::abs(v) / (2 * resists)).epsilon(1e-10));
  }
}

TEST_CASE("where one direction has no dry friction, a block on a spring turns back as if there were none") {
  const double k = 50, c = 3, m = 2, w = std::sqrt(k / m), x0 = -1;
  Mechanism mechanism = block(0, 0, k);
  mechanism.friction[0].coulomb = c;
  mechanism.friction[0].breakaway.reset();
  mechanism.friction[0].coulomb_backward = 0;
  Plant plant = started(mechanism, values({x0}), values({0}));
  // forwards about c / k, backwards about 0: the swing there and back ends at x0 + 2 c / k
  move(plant, pi / w, values({0}));
  CHECK(plant.position()[0] == doctest::Approx(-x0 - 2 * c / k).epsilon(1e-8));
  move(plant, 2 * pi / w, values({0}));
  CHECK(plant.position()[0] == doctest::Approx(x0 + 2 * c / k).epsilon(1e-8));
}

TEST_CASE("an oscillator loses two friction widths a half swing, and stays where the spring is too weak (A4)") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> part(0.3, 1);
  for (int turn = 0; turn < 12; ++turn) {
    const double m = 2, k = 100 * part(random), c = 4 * part(random), s = turn % 2 ? c : 1.4 * c;
    const double x0 = (3 + 12 * part(random)) * c / k, w = std::sqrt(k / m);
    CAPTURE(k);
    CAPTURE(c);
    CAPTURE(s);
    CAPTURE(x0);
    const Mechanism mechanism = block(c, s, k);
    double x = x0, t = 0;
    while (std::abs(x) * k > s) {
      x = -(std::abs(x) - 2 * c / k) * (x > 0 ? 1 : -1);
      t += pi / w;
    }
    Plant plant = started(mechanism, values({x0}), values({0}));
    const double first = 0.3 * pi / w;
    move(plant, first, values({0}));
    CHECK(plant.position()[0] == doctest::Approx(c / k + (x0 - c / k) * std::cos(w * first)).epsilon(1e-9));
    move(plant, t + 1e-6, values({0}));
    CHECK(plant.velocity()[0] == 0);
    CHECK(plant.position()[0] == doctest::Approx(x).epsilon(1e-8));
    const double stays = plant.position()[0];
    move(plant, t + 100, values({0}));
    CHECK(plant.position()[0] == stays);
    CHECK(plant.velocity()[0] == 0);
    CHECK(plant.cost().events <= 40);
  }
}

TEST_CASE("a pendulum is held for ever by friction that exceeds its weight, and falls where it does not (A4)") {
  const std::string text = R"(
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies: {x: {mass: 1, com: [0, -1], inertia: 0.01, points: {P: [0, 0]}}}
joints: {X: {type: revolute, connects: [ground.O, x.P]}}
actuators: [X]
friction: {X: {coulomb: 4}}
)";
  const Mechanism mechanism = spec(text);
  Plant plant = started(mechanism, values({0.3}), values({0}));
  for (int k = 0; k <= 100; ++k) {
    if (k > 0) move(plant, 10 * k, values({0}));
    const Sample& seen = plant.observe(values({0}));
    CHECK(seen.position[0] == 0.3);
    CHECK(seen.velocity[0] == 0);
    CHECK(seen.acceleration[0] == 0);
    CHECK(seen.shaking_force.norm() < 1e-12);
    CHECK(seen.joint_moment[0].z() == doctest::Approx(9.81 * std::sin(0.3)).epsilon(1e-12));
  }
  Plant heavy = started(mechanism, values({std::asin(4 / 9.81) + 1e-6}), values({0}));
  move(heavy, 1, values({0}));
  CHECK(heavy.velocity()[0] < 0);
}

TEST_CASE("a force that grows breaks a block loose at the moment when it exceeds static friction (A4)") {
  const double m = 2, c = 3, s = 4, rate = 8;
  Mechanism mechanism = block(c, s, 0);
  push(mechanism, {0, 10}, {0, 10 * rate});
  Plant plant = started(mechanism, values({0}), values({0}));
  const double loose = s / rate;
  move(plant, loose - 1e-6, values({0}));
  CHECK(plant.position()[0] == 0);
  move(plant, loose + 0.7, values({0}));
  const auto v = [&](double t) { return (rate * (t * t - loose * loose) / 2 - c * (t - loose)) / m; };
  CHECK(plant.velocity()[0] == doctest::Approx(v(loose + 0.7)).epsilon(1e-8));
}

TEST_CASE("a block goes with a swinging table, or slips on it, and what slipping takes is the energy lost (A4)") {
  const double coulomb = 1.5;
  const Mechanism mechanism = spec(R"(
space: planar
bodies:
  table: {mass: 1, com: [0, 0], inertia: 1, points: {A: [0, 0]}}
  block: {mass: 1, com: [0, 0], inertia: 1, points: {A: [0, 0]}}
ground: {points: {O: [0, 0]}}
joints:
  T: {type: prismatic, connects: [ground.O, table.A], axis: [1, 0]}
  B: {type: prismatic, connects: [table.A, block.A], axis: [1, 0]}
springs: {k: {between: [ground.O, table.A], stiffness: 50, free_length: 0}}
friction: {B: {coulomb: 1.5}}
actuators: [T]
)");
  // 50 N/m moves 2 kg: the block needs up to 25 x0 newtons to go with the table
  Plant together = started(mechanism, values({0.05, 0}), values({0, 0}));
  move(together, 3, values({0}));
  CHECK(together.position()[1] == 0);
  CHECK(together.position()[0] == doctest::Approx(0.05 * std::cos(5 * 3.0)).epsilon(1e-7));
  Plant apart = started(mechanism, values({0.5, 0}), values({0, 0}));
  // it slips at once: the table is left with 1 kg and a push outwards, the block is pulled after it
  const double t = 0.1, centre = coulomb / 50;
  move(apart, t, values({0}));
  CHECK(apart.position()[0] == doctest::Approx(centre + (0.5 - centre) * std::cos(std::sqrt(50.0) * t)).epsilon(1e-8));
  CHECK(apart.position()[0] + apart.position()[1] == doctest::Approx(0.5 - 0.5 * coulomb * t * t).epsilon(1e-8));
  const auto energy = [&] {
    const Sample& seen = apart.observe(values({0}));
    return seen.kinetic_energy + seen.potential_energy;
  };
  double lost = 0;
  const double before = energy();
  for (int k = 1; k <= 20000; ++k) {
    const double last = apart.position()[1];
    move(apart, t + 2e-4 * k, values({0}));
    lost += coulomb * std::abs(apart.position()[1] - last);  // but for the few samples in which it turns back
  }
  CHECK(before - energy() == doctest::Approx(lost).epsilon(1e-5));
  CHECK(apart.velocity()[1] == 0);  // in the end they go together
}

TEST_CASE("friction in all joints of a four-bar holds it up to the sum of what they hold, and not beyond (A4)") {
  const std::string text = R"(
space: planar
gravity: [0, 0]
bodies:
  crank: {mass: 1, com: [0.1, 0], inertia: 0.01, points: {A: [0, 0], B: [0.2, 0]}}
  coupler: {mass: 1, com: [0.25, 0], inertia: 0.02, points: {B: [0, 0], C: [0.5, 0]}}
  rocker: {mass: 1, com: [0.2, 0], inertia: 0.02, points: {D: [0, 0], C: [0.4, 0]}}
ground: {points: {A: [0, 0], D: [0.5, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
  B: {type: revolute, connects: [crank.B, coupler.B]}
  C: {type: revolute, connects: [coupler.C, rocker.C]}
  D: {type: revolute, connects: [ground.D, rocker.D]}
actuators: [A]
assembly: {A: 1.2, B: -0.76, D: 1.5}
)";
  const Mechanism bare = spec(text);
  const Mechanism rubbing = spec(text +
                                 "friction: {A: {coulomb: 1, static: 1.2}, B: {coulomb: 0.5}, C: {coulomb: 0.4, "
                                 "static: 0.9}, D: {coulomb: 0.7}}\n");
  const VectorX start = values({1.2, -0.76, 1.0685, 1.5085}), none = values({0, 0, 0, 0});
  Plant free = started(bare, start, none);
  // rates of all joints for one of the crank: what a unit torque there would have to overcome
  const VectorX unit = free.acceleration(values({1})) / free.acceleration(values({1}))[0];
  const double limit = 1.2 + 0.5 * std::abs(unit[1]) + 0.9 * std::abs(unit[2]) + 0.7 * std::abs(unit[3]);
  for (const double sign : {1.0, -1.0}) {
    Plant plant = started(rubbing, start, none);
    const VectorX stands = plant.position();
    move(plant, 2, values({sign * limit * 0.9999999}));
    CHECK(plant.position() == stands);
    CHECK(plant.velocity().cwiseAbs().maxCoeff() == 0);
    const Sample held = plant.observe(values({sign * limit * 0.5}));
    CHECK(held.acceleration.cwiseAbs().maxCoeff() < 1e-12);
    CHECK(held.shaking_force.norm() < 1e-12);
    const double torque = sign * limit * 1.01;
    const double sliding = 1 + 0.5 * std::abs(unit[1]) + 0.4 * std::abs(unit[2]) + 0.7 * std::abs(unit[3]);
    CHECK(plant.acceleration(values({torque}))[0] ==
          doctest::Approx(free.acceleration(values({torque - sign * sliding}))[0]).epsilon(1e-9));
    move(plant, 2.05, values({torque}));
    CHECK(plant.velocity()[0] * sign > 0);
    // motors' work less what friction takes is the energy gained
    double friction = 0, work = 0, before = plant.observe(values({torque})).kinetic_energy;
    VectorX last = plant.position();
    for (int k = 1; k <= 200; ++k) {
      move(plant, 2.05 + 1e-4 * k, values({torque}));
      const VectorX moved = (plant.position() - last).cwiseAbs();
      work += torque * (plant.position() - last)[0];
      friction += moved[0] + 0.5 * moved[1] + 0.4 * moved[2] + 0.7 * moved[3];
      last = plant.position();
    }
    CHECK(plant.observe(values({torque})).kinetic_energy - before == doctest::Approx(work - friction).epsilon(1e-7));
  }
  Plant spun = started(rubbing, start, values({3, 0, 0, 0}));
  move(spun, 30, values({0}));
  CHECK(spun.velocity().cwiseAbs().maxCoeff() == 0);
  const VectorX rests = spun.position();
  move(spun, 60, values({0}));
  CHECK(spun.position() == rests);
}

TEST_CASE("a geared pair sticks by the friction of both shafts, the slow one's by the ratio (A4)") {
  const Mechanism mechanism = spec(R"(
space: planar
bodies:
  small: {mass: 1, com: [0, 0], inertia: 0.01, points: {A: [0, 0]}}
  large: {mass: 1, com: [0, 0], inertia: 0.2, points: {A: [0, 0]}}
ground: {points: {O: [0, 0], P: [1, 0]}}
joints:
  S: {type: revolute, connects: [ground.O, small.A]}
  L: {type: revolute, connects: [ground.P, large.A]}
couplings: [{joint: L, follows: S, ratio: -0.25}]
friction: {S: {coulomb: 0.1}, L: {coulomb: 2, static: 3}}
actuators: [S]
)");
  const double inertia = 0.01 + 0.2 / 16, holds = 0.1 + 3 * 0.25, slides = 0.1 + 2 * 0.25;
  Plant plant = started(mechanism, values({0, 0}), values({0, 0}));
  move(plant, 1, values({0.999999 * holds}));
  CHECK(plant.position()[0] == 0);
  move(plant, 2, values({1.1 * holds}));
  CHECK(plant.velocity()[0] == doctest::Approx((1.1 * holds - slides) / inertia).epsilon(1e-9));
  move(plant, 20, values({0}));
  CHECK(plant.velocity().cwiseAbs().maxCoeff() == 0);
}

TEST_CASE("an arm's joint that sticks is carried by the others as if welded (A4)") {
  const std::string text = R"(
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 1, com: [0, -0.5], inertia: 0.0833, points: {A: [0, 0], B: [0, -1]}}
  lower: {mass: 1, com: [0, -0.5], inertia: 0.0833, points: {B: [0, 0], E: [0, -1]}}
joints:
  J1: {type: revolute, connects: [ground.O, upper.A]}
  J2: {type: revolute, connects: [upper.B, lower.B]}
actuators: [J1, J2]
friction: {J2: {coulomb: 100}}
)";
  const Mechanism arm = spec(text);
  Plant plant = started(arm, values({1, 0.5}), values({0, 0}));
  const auto energy = [&] {
    const Sample& seen = plant.observe(values({0, 0}));
    return seen.kinetic_energy + seen.potential_energy;
  };
  const double before = energy();
  for (int k = 1; k <= 20; ++k) {
    move(plant, 0.25 * k, values({0, 0}));
    CHECK(plant.position()[1] == 0.5);
    CHECK(plant.velocity()[1] == 0);
    CHECK(energy() == doctest::Approx(before).epsilon(1e-8));
  }
  CHECK(plant.velocity()[0] != 0);
}

TEST_CASE("a block that stops for less than a step stands until the force that grows breaks it loose (A4)") {
  const double m = 2, c = 3, s = 4, rate = 2e5;  // [N/s]: all within a millisecond
  for (const double short_of : {1e-7, 1e-5, 1e-3}) {
    CAPTURE(short_of);
    // without friction's turning round it would move on: its least rate is just below zero
    Mechanism mechanism = block(c, s, 0);
    const double back = -20, turn = (c - back) / rate;  // when force and friction cancel
    const double v0 = rate * turn * turn / (2 * m) * (1 - short_of);
    push(mechanism, {0, 1}, {back, back + rate});
    for (const double longest : {0.05, 1e-4}) {
      PlantOptions options = tight();
      options.max_step = longest;
      Plant plant = started(mechanism, values({0}), values({v0}), options);
      const double loose = (s - back) / rate, end = 2 * loose;
      move(plant, end, values({0}));
      const double force = rate * (end * end - loose * loose) / 2 + (back - c) * (end - loose);
      CHECK(plant.velocity()[0] == doctest::Approx(force / m).epsilon(1e-8));
      CHECK(plant.cost().events >= 2);
    }
  }
}

TEST_CASE("what sticks and slips under a force that comes and goes does not depend on the longest step (A4)") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> part(-1, 1);
  for (int turn = 0; turn < 20; ++turn) {
    CAPTURE(turn);
    Mechanism mechanism = block(2, turn % 2 ? 2 : 3, 30);
    std::vector<double> time, force;
    for (int k = 0; k <= 20; ++k) time.push_back(0.1 * k), force.push_back(6 * part(random));
    push(mechanism, time, force);
    PlantOptions coarse = tight(), fine = tight();
    fine.max_step = 1e-4;
    Plant first = started(mechanism, values({0.05}), values({0}), coarse),
          second = started(mechanism, values({0.05}), values({0}), fine);
    for (int k = 1; k <= 8; ++k) {
      move(first, 0.25 * k, values({0}));
      move(second, 0.25 * k, values({0}));
      CHECK(first.position()[0] == doctest::Approx(second.position()[0]).epsilon(1e-8));
      CHECK(std::abs(first.velocity()[0] - second.velocity()[0]) < 1e-8);
    }
  }
}

}  // namespace stiction_test
