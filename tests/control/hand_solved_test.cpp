// Motions that a textbook solves.

#include "plant_cases.hpp"

#include <cmath>
#include <numbers>

namespace hand_solved_test {

using namespace plants;

namespace {

constexpr double pi = std::numbers::pi;

}  // namespace

TEST_CASE("a pendulum released at 2.5 rad is back after the period of the elliptic integral") {
  const Mechanism pendulum = spec(R"(
space: planar
gravity: [0, -9.81]
bodies: {rod: {mass: 2, com: [0, -0.4], inertia: 0.1, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {J: {type: revolute, connects: [ground.O, rod.A]}}
actuators: [J]
)");
  const double inertia = 0.1 + 2 * 0.4 * 0.4, release = 2.5;
  const double period = 4 * std::sqrt(inertia / (2 * 9.81 * 0.4)) * std::comp_ellint_1(std::sin(release / 2));
  Plant plant = started(pendulum, values({release}), values({0}));
  move(plant, period / 4, values({0}));
  CHECK(std::abs(plant.position()[0]) < 1e-9);
  CHECK(plant.velocity()[0] == doctest::Approx(-std::sqrt(2 * 2 * 9.81 * 0.4 * (1 - std::cos(release)) / inertia)));
  move(plant, period, values({0}));
  CHECK(plant.position()[0] == doctest::Approx(release).epsilon(1e-9));
  CHECK(std::abs(plant.velocity()[0]) < 1e-8);
}

TEST_CASE("a mass on a spring with viscous friction swings out as the closed form says") {
  const Mechanism block = spec(R"(
space: planar
bodies: {block: {mass: 2, com: [0, 0], inertia: 0.1, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {S: {type: prismatic, connects: [ground.O, block.A], axis: [1, 0]}}
springs: {k: {between: [ground.O, block.A], stiffness: 50, free_length: 0}}
friction: {S: {viscous: 3}}
actuators: [S]
)");
  const double m = 2, k = 50, c = 3, x0 = 0.2, force = 4;
  const double decay = c / (2 * m), w = std::sqrt(k / m - decay * decay), rest = force / k;
  Plant plant = started(block, values({x0}), values({0}));
  for (const double t : {0.3, 1.0, 2.7}) {
    move(plant, t, values({force}));
    const double x = rest + std::exp(-decay * t) * (x0 - rest) * (std::cos(w * t) + decay / w * std::sin(w * t));
    CHECK(plant.position()[0] == doctest::Approx(x).epsilon(1e-9));
  }
}

TEST_CASE("a link on a torsion spring swings harmonically about its rest, however often it turns") {
  const Mechanism link = spec(R"(
space: planar
bodies: {link: {mass: 2, com: [0.3, 0], inertia: 0.05, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {J: {type: revolute, connects: [ground.O, link.A]}}
springs: {t: {joint: J, stiffness: 4, rest: 0.2}}
actuators: [J]
)");
  const double w = std::sqrt(4 / (0.05 + 2 * 0.3 * 0.3)), away = 9;  // nearly three turns to and fro
  Plant plant = started(link, values({0.2 + away}), values({0}));
  for (const double t : {0.1, 0.7, 2.3}) {
    move(plant, t, values({0}));
    CHECK(plant.position()[0] == doctest::Approx(0.2 + away * std::cos(w * t)).epsilon(1e-9));
  }
}

TEST_CASE("Coulomb friction brings a block to rest where work says, and holds it against less than itself") {
  const Mechanism block = spec(R"(
space: planar
bodies: {block: {mass: 2, com: [0, 0], inertia: 0.1, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {S: {type: prismatic, connects: [ground.O, block.A], axis: [1, 0]}}
friction: {S: {coulomb: 5}}
actuators: [S]
)");
  Plant plant = started(block, values({0}), values({1.5}));
  move(plant, 0.3, values({0}));
  CHECK(plant.velocity()[0] == doctest::Approx(1.5 - 2.5 * 0.3).epsilon(1e-9));
  move(plant, 2, values({0}));
  CHECK(plant.position()[0] == doctest::Approx(2 * 1.5 * 1.5 / (2 * 5)).epsilon(1e-12));
  const double stands = plant.position()[0];
  move(plant, 3, values({4.5}));
  CHECK(plant.velocity()[0] == 0);
  CHECK(plant.position()[0] == stands);
  move(plant, 4, values({6}));
  CHECK(plant.velocity()[0] == doctest::Approx(0.5).epsilon(1e-12));
  CHECK(plant.observe(values({6})).friction_power == doctest::Approx(5 * plant.velocity()[0]));
}

TEST_CASE("an Atwood machine with a heavy pulley falls as its reduced mass says") {
  const Mechanism atwood = spec(R"(
space: planar
gravity: [0, -9.81]
bodies:
  wheel: {mass: 4, com: [0, 0], inertia: 0.02, points: {A: [0, 0]}}
  left: {mass: 3, com: [0, 0], inertia: 0.1, points: {A: [0, 0]}}
  right: {mass: 2, com: [0, 0], inertia: 0.1, points: {A: [0, 0]}}
ground: {points: {O: [0, 0], L: [-0.1, -1], R: [0.1, -1]}}
joints:
  W: {type: revolute, connects: [ground.O, wheel.A]}
  L: {type: prismatic, connects: [ground.L, left.A], axis: [0, -1]}
  R: {type: prismatic, connects: [ground.R, right.A], axis: [0, 1]}
couplings: [{joint: L, follows: W, ratio: 0.1}, {joint: R, follows: W, ratio: 0.1}]
actuators: [W]
)");
  Plant plant = started(atwood, values({0, 0, 0}), values({0, 0, 0}));
  const double a = (3 - 2) * 9.81 / (3 + 2 + 0.02 / (0.1 * 0.1));
  CHECK(plant.acceleration(values({0}))[1] == doctest::Approx(a).epsilon(1e-12));
  move(plant, 0.7, values({0}));
  CHECK(plant.position()[2] == doctest::Approx(a * 0.7 * 0.7 / 2).epsilon(1e-10));
  // a torque that holds it
  CHECK(std::abs(plant.acceleration(values({-9.81 * 0.1}))[0]) < 1e-10);
}

TEST_CASE("a heavy top spins on in steady precession through every orientation of its spherical joint") {
  const Mechanism top = spec(R"(
space: spatial
gravity: [0, 0, -9.81]
bodies: {top: {mass: 1.5, com: [0, 0, 0.2], inertia: [0.01, 0.01, 0.004], points: {A: [0, 0, 0]}}}
ground: {points: {O: [0, 0, 0]}}
joints: {B: {type: spherical, connects: [ground.O, top.A]}}
)");
  const double tilt = 1.1, precession = 4, I1 = 0.01 + 1.5 * 0.04, I3 = 0.004;
  const double spin = (1.5 * 9.81 * 0.2 / precession + I1 * precession * std::cos(tilt)) / I3;  // about its own axis
  const VectorX none(0);
  Plant plant(top, tight());
  REQUIRE(plant.start(0, values({tilt, 0, 0}), values({0, precession * std::sin(tilt), spin})).status ==
          MotionStatus::done);
  CHECK(plant.freedoms() == 3);
  double energy = 0;
  for (int k = 0; k <= 20; ++k) {
    const double t = 0.1 * k, turned = precession * t;
    if (k > 0) move(plant, t, none);
    const Sample& seen = plant.observe(none);
    const Vector3 com =
        0.2 * Vector3(std::sin(tilt) * std::sin(turned), -std::sin(tilt) * std::cos(turned), std::cos(tilt));
    CHECK((seen.com - com).norm() < 1e-8);
    if (k == 0) energy = seen.kinetic_energy + seen.potential_energy;
    CHECK(seen.kinetic_energy + seen.potential_energy == doctest::Approx(energy).epsilon(1e-9));
  }
}

TEST_CASE("a double pendulum without weight turns about its pivot with constant angular momentum") {
  Mechanism mechanism = config("double-pendulum.yaml").mechanism;
  mechanism.gravity.setZero();
  Plant plant = started(mechanism, values({0.3, 1.2}), values({2, -5}));
  const VectorX none = nothing(mechanism);
  const auto momentum = [&] {
    const dynamics::EquationOfMotion equation = plant.equation();
    return (equation.mass * plant.velocity())[0];
  };
  const double start = momentum();
  for (int k = 1; k <= 10; ++k) {
    move(plant, 0.2 * k, none);
    CHECK(std::abs(plant.observe(none).shaking_moment.z()) < 1e-9);
    CHECK(momentum() == doctest::Approx(start).epsilon(1e-9));
  }
}

TEST_CASE("a motion with all its rates turned round goes back where it came from") {
  for (const std::string file : {"double-pendulum.yaml", "5r.yaml", "spatial-slider-crank.yaml"}) {
    CAPTURE(file);
    const Study study = config(file);
    const Mechanism mechanism = conservative(study.mechanism);
    const Known state = moment_of(study, 0.4);
    const VectorX none = nothing(mechanism);
    Plant plant = started(mechanism, state.q, state.dq);
    move(plant, 0.5, none);
    Plant back = started(mechanism, plant.position(), -plant.velocity());
    move(back, 0.5, none);
    for (Eigen::Index c = 0; c < state.q.size(); ++c) {
      const double off = back.position()[c] - state.q[c];  // whole turns are counted from each start
      const bool angle = mechanism.coordinates[c].kind == CoordinateKind::angle;
      CHECK(std::abs(angle ? std::remainder(off, 2 * pi) : off) < 1e-7);
    }
    CHECK((back.velocity() + state.dq).cwiseAbs().maxCoeff() < 1e-6);
  }
}

TEST_CASE("a parallelogram stops at its change point, with the time that its constant speed gives") {
  const Study study = config("parallelogram.yaml");
  Mechanism mechanism = conservative(study.mechanism);
  mechanism.gravity.setZero();
  mechanism.springs.clear();
  const Known state = moment_of(study, 0.5);
  Plant plant = started(mechanism, state.q, state.dq);
  const double q0 = plant.position()[0], w = plant.velocity()[0];
  const MotionOutcome outcome = plant.advance(20 / std::abs(w), nothing(mechanism));
  CHECK_MESSAGE(outcome.status == MotionStatus::constraint_singularity, outcome.reason);
  CHECK(outcome.reason.find("at t = ") == 0);
  CHECK(plant.time() == outcome.time);
  const double end = w > 0 ? std::ceil(q0 / pi) * pi : std::floor(q0 / pi) * pi;
  CHECK(outcome.time == doctest::Approx((end - q0) / w).epsilon(1e-4));
  CHECK(plant.velocity()[0] == doctest::Approx(w).epsilon(1e-5));  // where the closures have 1e-5 of their rank left
}

TEST_CASE("bad use is refused") {
  const Mechanism mechanism = config("rr.yaml").mechanism;
  PlantOptions options;
  options.relative_tolerance = 1;
  CHECK_THROWS_AS(Plant(mechanism, options), std::invalid_argument);
  Plant plant(mechanism);
  CHECK_THROWS_AS(plant.advance(1, nothing(mechanism)), std::invalid_argument);
  CHECK_THROWS_AS(plant.start(0, values({1}), values({1})), std::invalid_argument);
  REQUIRE(plant.start(0, values({0.1, 0.2}), values({0, 0})).status == MotionStatus::done);
  CHECK_THROWS_AS(plant.advance(1, values({1})), std::invalid_argument);
}

}  // namespace hand_solved_test
