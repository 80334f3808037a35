#include "arms.hpp"

#include "balance/motion/control/plant.hpp"

#include <algorithm>

using namespace arms;

TEST_CASE(
    "computed torque with an exact model: the error is that of a linear system of second order, up to the sampling") {
  // e'' + 2 ζ ω e' + ω² e = 0 with e(0) = e0, e'(0) = 0
  const double omega = 20, e0 = 0.1;
  const auto response = [&](double zeta, double t) {
    if (zeta == 1) return e0 * (1 + omega * t) * std::exp(-omega * t);
    const double damped = omega * std::sqrt(1 - zeta * zeta);
    return e0 * std::exp(-zeta * omega * t) * (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t));
  };
  const Study arm_study = arm(), loop_study = five_bar();
  for (const double zeta : {1.0, 0.5}) {
    for (const Study* study : {&arm_study, &loop_study}) {
      double before = 0;
      for (const double rate : {2000.0, 4000.0}) {
        const auto& motors = study->mechanism.actuators;
        const long count = static_cast<long>(motors.size());
        Controller c = controller(study::ControllerType::computed_torque, rate);
        c.kp = all(count, omega * omega);
        c.kd = all(count, 2 * zeta * omega);
        c.initial_error.joints = {{motors[0], -e0}};
        const RunResult r = run(*study, "cycloid", c, 51);
        double worst = 0;
        for (long k = 0; k < r.time.size(); ++k)
          worst = std::max(worst, std::abs(r.tracking_error(k, motors[0]) - response(zeta, r.time[k])));
        CHECK(worst <
              20 * e0 / rate * omega / 10);  // a hold delays by half a period: e0 ω h at most, with room for both terms
        if (before > 0) CHECK(before / worst == doctest::Approx(2).epsilon(0.1));  // of first order in the period
        before = worst;
      }
    }
  }
}

TEST_CASE("PD with weight compensated leaves at rest what the unknown payload weighs: Kp e = g cos q") {
  const double kp = 300;
  for (const bool known : {true, false}) {
    Study study = arm();
    Controller c = controller(study::ControllerType::pd, 1000);
    c.kp = all(1, kp);
    c.kd = all(1, 60);
    if (!known) {
      c.model = study.mechanism;
      c.model->attachments.clear();
    }
    const RunResult r = run(study, "cycloid", c, 101, 3);
    const long last = r.time.size() - 1;
    CHECK(r.time[last] == doctest::Approx(4));
    // kp (1.2 − q) = 0.5 · 0.8 · g cos q, by fixed-point iteration
    double q = 1.2;
    for (int i = 0; i < 100; ++i) q = 1.2 - (known ? 0 : cargo_moment * g * std::cos(q) / kp);
    CHECK(r.joint_position(last, 0) == doctest::Approx(q).epsilon(1e-6));
    CHECK(r.torque(last, 0) == doctest::Approx((own_moment + cargo_moment) * g * std::cos(q)).epsilon(1e-5));
  }
}

TEST_CASE("PD without compensation carries the whole weight on its spring") {
  Controller c = controller(study::ControllerType::pd, 1000);
  c.kp = all(1, 300);
  c.kd = all(1, 60);
  c.gravity = study::GravityCompensation::ignored;
  const RunResult r = run(arm(), "cycloid", c, 101, 3);
  double q = 1.2;
  for (int i = 0; i < 200; ++i) q = 1.2 - (own_moment + cargo_moment) * g * std::cos(q) / 300;
  CHECK(r.joint_position(r.time.size() - 1, 0) == doctest::Approx(q).epsilon(1e-6));
}

TEST_CASE("gains from a bandwidth: PD treats each motor as the inertia that it feels at the start") {
  const Study study = arm("", "0");
  Controller given = controller(study::ControllerType::pd, 1000), derived = given;
  derived.bandwidth = 2;
  derived.damping = 0.7;
  const double omega = derived.natural_frequency();
  given.kp = all(1, inertia * omega * omega);
  given.kd = all(1, 2 * 0.7 * inertia * omega);
  const RunResult a = run(study, "cycloid", given), b = run(study, "cycloid", derived);
  CHECK((a.joint_position - b.joint_position).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("an unknown payload moves computed torque off by what it weighs, sliding mode hardly at all") {
  Study study = arm();
  Controller torque = controller(study::ControllerType::computed_torque, 2000), sliding = torque;
  torque.kp = all(1, 400);
  torque.kd = all(1, 40);
  torque.model = study.mechanism;
  torque.model->attachments.clear();
  sliding.type = study::ControllerType::sliding_mode;
  sliding.model = torque.model;
  sliding.lambda = all(1, 20);
  // The payload's weight and inertia force over the model's inertia are below 12 + 3 rad/s².
  sliding.switching_gain = all(1, 30);
  const RunResult a = run(study, "cycloid", torque, 101, 2), b = run(study, "cycloid", sliding, 101, 2);
  const double rest = a.tracking_error(a.time.size() - 1, 0);
  // I_own kp e = cargo weight at the place where it comes to rest
  CHECK(own_inertia * 400 * rest == doctest::Approx(cargo_moment * g * std::cos(1.2 - rest)).epsilon(1e-5));
  CHECK(metric(b, "tracking_error").peak < 0.05 * metric(a, "tracking_error").peak);
}

TEST_CASE("open loop: stated torques act as stated, held between samples; their variation is known") {
  const Study study = arm("", "0");
  Controller c = controller(study::ControllerType::open_loop, 100);
  c.efforts = {{0, 0.5, 1}, {all(1, 0), all(1, 2), all(1, 0)}};
  c.efforts.is_held = true;
  const RunResult r = run(study, "rest", c, 501);
  // Steps of 0.04 N m up to 2 and down again; the last sample of the controller is one step before the end.
  CHECK(metric(r, "torque_variation[J]").peak == doctest::Approx(2 + 2 - 0.04).epsilon(1e-9));
  // I q̇ = the sum of held torques: those of both ramps add up to 50 · 2 · 0.01
  CHECK(r.joint_velocity(r.time.size() - 1, 0) == doctest::Approx(1.0 / inertia).epsilon(1e-8));
}

TEST_CASE(
    "open loop without torques stated feeds forward the inverse dynamics: it follows as the period goes to zero") {
  const Study study = arm("", "0");  // with weight, an upright arm in open loop would fall
  double before = 0;
  for (const double rate : {500.0, 1000.0}) {
    const RunResult r = run(study, "cycloid", controller(study::ControllerType::open_loop, rate), 101);
    const double worst = metric(r, "tracking_error").peak;
    CHECK(worst < 4 / rate);
    if (before > 0) CHECK(before / worst == doctest::Approx(2).epsilon(0.1));
    before = worst;
  }
}

TEST_CASE("none and zero gains are free motion: the pendulum's energy stays, and both are the same motion") {
  const Study study = arm();
  const RunResult free = run(study, "rest", controller(study::ControllerType::none, 1000), 201);
  Controller zero = controller(study::ControllerType::pd, 1000);
  zero.kp = zero.kd = all(1, 0);
  zero.gravity = study::GravityCompensation::ignored;
  const RunResult idle = run(study, "rest", zero, 201);
  CHECK(free.torque.cwiseAbs().maxCoeff() == 0);
  CHECK(free.energy == 0);
  CHECK((free.joint_position - idle.joint_position).cwiseAbs().maxCoeff() < 1e-7);
  const auto energy = free.kinetic_energy + free.potential_energy;
  CHECK((energy.array() - energy(0, 0)).abs().maxCoeff() < 1e-7 * free.kinetic_energy.maxCoeff());
  // the pendulum's first integral, by hand
  for (long k = 0; k < free.time.size(); k += 20) {
    const double fallen = std::sin(0.2) - std::sin(free.joint_position(k, 0));
    CHECK(inertia / 2 * std::pow(free.joint_velocity(k, 0), 2) ==
          doctest::Approx((own_moment + cargo_moment) * g * fallen).epsilon(1e-6));
  }
}
