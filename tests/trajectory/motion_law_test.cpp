#include "balance/mechanics/trajectory/motion_law.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace motion_law_test {

using namespace balance;
using namespace balance::trajectory;

namespace {

constexpr double pi = std::numbers::pi;

struct NamedLaw {
  std::string name;
  MotionLaw law;
};

std::vector<NamedLaw> symmetric_laws() {
  return {{"cycloidal", {MotionLawKind::cycloidal}},
          {"bang-bang", {MotionLawKind::bang_bang}},
          {"uniform", {MotionLawKind::uniform}},
          {"cubic", {MotionLawKind::cubic}},
          {"3-4-5", {MotionLawKind::polynomial_345}},
          {"4-5-6-7", {MotionLawKind::polynomial_4567}},
          {"harmonic", {MotionLawKind::harmonic}},
          {"modified sine", {MotionLawKind::modified_sine}},
          {"modified trapezoidal", {MotionLawKind::modified_trapezoidal}},
          {"trapezoidal velocity", {MotionLawKind::trapezoidal_velocity}},
          {"ramps of a third", {MotionLawKind::trapezoidal_velocity, 1.0 / 3, 1.0 / 3}},
          {"ramps of a half", {MotionLawKind::trapezoidal_velocity, 0.5, 0.5}}};
}

std::vector<NamedLaw> all_laws() {
  std::vector<NamedLaw> laws = symmetric_laws();
  laws.push_back({"uneven ramps", {MotionLawKind::trapezoidal_velocity, 0.1, 0.6}});
  laws.push_back({"ramps that meet to within round-off", {MotionLawKind::trapezoidal_velocity, 0.3, 0.7}});
  return laws;
}

bool near_jump(const MotionLaw& law, double tau, double distance) {
  const std::vector<double> at = find_acceleration_jumps(law);
  return std::any_of(at.begin(), at.end(), [&](double jump) { return std::abs(tau - jump) < distance; });
}

struct Peak {
  double velocity = 0, acceleration = 0;
};

/// On a grid of 1/40320, which holds every place where one of the laws peaks at a simple fraction.
Peak peak_of(const MotionLaw& law) {
  Peak peak;
  constexpr int steps = 40320;
  for (int i = 0; i <= steps; ++i) {
    const MotionLawValue value = evaluate(law, static_cast<double>(i) / steps);
    peak.velocity = std::max(peak.velocity, std::abs(value.ds));
    peak.acceleration = std::max(peak.acceleration, std::abs(value.dds));
  }
  return peak;
}

}  // namespace

TEST_CASE("every law starts at exactly 0 and ends at exactly 1") {
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    for (const Side side : {Side::before, Side::after}) {
      CHECK(evaluate(law, 0, side).s == 0);
      CHECK(evaluate(law, 1, side).s == 1);
    }
  }
}

TEST_CASE("every law but the uniform one starts and ends at rest exactly") {
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    const double expected = law.kind == MotionLawKind::uniform ? 1 : 0;
    CHECK(evaluate(law, 0).ds == expected);
    CHECK(evaluate(law, 1).ds == expected);
  }
}

TEST_CASE("laws without shock start and end with exactly no acceleration") {
  for (const MotionLawKind kind :
       {MotionLawKind::cycloidal, MotionLawKind::polynomial_345, MotionLawKind::polynomial_4567,
        MotionLawKind::modified_sine, MotionLawKind::modified_trapezoidal}) {
    CAPTURE(static_cast<int>(kind));
    CHECK(evaluate({kind}, 0).dds == 0);
    CHECK(evaluate({kind}, 1).dds == 0);
  }
}

TEST_CASE("at the ends the inner limit is taken whatever side is asked for") {
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    // the acceleration is continuous inside, so a little further in it is nearly the same (its slope is below 400)
    CHECK(evaluate(law, 0, Side::before).dds == evaluate(law, 0, Side::after).dds);
    CHECK(evaluate(law, 1, Side::before).dds == evaluate(law, 1, Side::after).dds);
    CHECK(std::abs(evaluate(law, 0, Side::before).dds - evaluate(law, 1e-9).dds) < 1e-6);
    CHECK(std::abs(evaluate(law, 1, Side::after).dds - evaluate(law, 1 - 1e-9).dds) < 1e-6);
  }
}

TEST_CASE("the derivatives of every law meet central differences away from jumps") {
  constexpr double h = 1e-5;
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    for (int i = 1; i < 997; ++i) {
      const double tau = i / 997.0;
      if (near_jump(law, tau, 2 * h)) continue;
      CAPTURE(tau);
      const MotionLawValue left = evaluate(law, tau - h), here = evaluate(law, tau), right = evaluate(law, tau + h);
      // truncation: h²/6 times a derivative below 1e4 where it is continuous, h/2 times one below 1e3 where it is not
      CHECK(std::abs((right.s - left.s) / (2 * h) - here.ds) < 1e-6);
      const bool kink = std::abs(tau - std::round(tau * 8) / 8) < 2 * h;
      CHECK(std::abs((right.ds - left.ds) / (2 * h) - here.dds) < (kink ? 1e-2 : 1e-6));
    }
  }
}

TEST_CASE("position and velocity are continuous at every seam of every law") {
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    std::vector<double> seams = find_acceleration_jumps(law);
    for (const double seam : {0.125, 0.375, 0.5, 0.625, 0.875}) seams.push_back(seam);
    for (const double seam : seams) {
      const MotionLawValue left = evaluate(law, std::nextafter(seam, 0.0)),
                           right = evaluate(law, std::nextafter(seam, 1.0));
      CHECK(std::abs(left.s - right.s) < 4e-15);  // round-off: s ≤ 1, ds ≤ 2.2
      CHECK(std::abs(left.ds - right.ds) < 4e-14);
      if (!near_jump(law, seam, 1e-6)) CHECK(std::abs(left.dds - right.dds) < 1e-13);
    }
  }
}

TEST_CASE("symmetric laws satisfy s(τ) + s(1 − τ) = 1") {
  for (const auto& [name, law] : symmetric_laws()) {
    CAPTURE(name);
    for (int i = 0; i <= 1000; ++i) {
      const double tau = i / 1000.0;
      const MotionLawValue a = evaluate(law, tau, Side::after), b = evaluate(law, 1 - tau, Side::before);
      CHECK(std::abs(a.s + b.s - 1) < 2e-15);  // round-off; 1 − τ is rounded too
      CHECK(std::abs(a.ds - b.ds) < 1e-14);
      if (!near_jump(law, tau, 1e-9)) CHECK(std::abs(a.dds + b.dds) < 1e-13);
    }
  }
}

TEST_CASE("no law goes backwards") {
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    for (int i = 0; i <= 1000; ++i) CHECK(evaluate(law, i / 1000.0).ds >= 0);
  }
}

TEST_CASE("the peak velocity and acceleration of every law are those of the literature") {
  const auto check = [](MotionLawKind kind, double velocity, double acceleration) {
    CAPTURE(static_cast<int>(kind));
    const Peak peak = peak_of({kind});
    // a grid of 1/40320 misses a parabolic peak by at most (1/80640)² / 2 times a curvature below 300
    CHECK(peak.velocity == doctest::Approx(velocity).epsilon(1e-9));
    CHECK(peak.acceleration == doctest::Approx(acceleration).epsilon(5e-8));
  };
  check(MotionLawKind::cycloidal, 2, 2 * pi);
  check(MotionLawKind::bang_bang, 2, 4);
  check(MotionLawKind::uniform, 1, 0);
  check(MotionLawKind::cubic, 1.5, 6);
  check(MotionLawKind::polynomial_345, 15.0 / 8, 10 / std::sqrt(3.0));
  check(MotionLawKind::polynomial_4567, 35.0 / 16, 84 * std::sqrt(5.0) / 25);
  check(MotionLawKind::harmonic, pi / 2, pi * pi / 2);
  check(MotionLawKind::modified_sine, 4 * pi / (4 + pi), 4 * pi * pi / (4 + pi));
  check(MotionLawKind::modified_trapezoidal, 2, 8 * pi / (2 + pi));
}

TEST_CASE("the printed peaks of modified sine and modified trapezoid come out of their closed forms") {
  const Peak sine = peak_of({MotionLawKind::modified_sine}), trapezoid = peak_of({MotionLawKind::modified_trapezoidal});
  // the tables print four decimals
  CHECK(std::abs(sine.velocity - 1.7596) < 5e-5);
  CHECK(std::abs(sine.acceleration - 5.5280) < 5e-5);
  CHECK(std::abs(trapezoid.acceleration - 4.8881) < 5e-5);
}

TEST_CASE("the cycloidal law is P3 eq. 52") {
  for (int i = 0; i <= 100; ++i) {
    const double tau = i / 100.0;
    const MotionLawValue value = evaluate({MotionLawKind::cycloidal}, tau);
    CHECK(std::abs(value.s - (tau - std::sin(2 * pi * tau) / (2 * pi))) < 1e-15);  // round-off
    CHECK(std::abs(value.ds - (1 - std::cos(2 * pi * tau))) < 1e-14);
    CHECK(std::abs(value.dds - 2 * pi * std::sin(2 * pi * tau)) < 1e-14);
  }
}

TEST_CASE("bang-bang turns from +4 to −4 at exactly one half, and the side decides there") {
  const MotionLaw law{MotionLawKind::bang_bang};
  CHECK(find_acceleration_jumps(law) == std::vector<double>{0.5});
  CHECK(evaluate(law, 0.5, Side::before).dds == 4);
  CHECK(evaluate(law, 0.5, Side::after).dds == -4);
  CHECK(evaluate(law, std::nextafter(0.5, 0.0), Side::after).dds == 4);
  CHECK(evaluate(law, std::nextafter(0.5, 1.0), Side::before).dds == -4);
  CHECK(evaluate(law, 0.5, Side::before).s == 0.5);
  CHECK(evaluate(law, 0.5, Side::after).s == 0.5);
}

TEST_CASE("a trapezoidal velocity jumps where its ramps end, and only once where they meet") {
  const MotionLaw law{MotionLawKind::trapezoidal_velocity, 0.1, 0.6};
  const double velocity = 1 / (1 - 0.35);
  REQUIRE(find_acceleration_jumps(law).size() == 2);
  CHECK(find_acceleration_jumps(law)[0] == 0.1);
  CHECK(find_acceleration_jumps(law)[1] == doctest::Approx(0.4));
  CHECK(evaluate(law, find_acceleration_jumps(law)[0], Side::before).dds == doctest::Approx(velocity / 0.1));
  CHECK(evaluate(law, find_acceleration_jumps(law)[0], Side::after).dds == 0);
  CHECK(evaluate(law, find_acceleration_jumps(law)[1], Side::before).dds == 0);
  CHECK(evaluate(law, find_acceleration_jumps(law)[1], Side::after).dds == doctest::Approx(-velocity / 0.6));
  CHECK(evaluate(law, 0.25).ds == doctest::Approx(velocity));

  const MotionLaw triangle{MotionLawKind::trapezoidal_velocity, 0.3, 0.7};  // 1 − 0.7 is not 0.3 in binary
  REQUIRE(find_acceleration_jumps(triangle).size() == 1);
  CHECK(evaluate(triangle, find_acceleration_jumps(triangle)[0], Side::before).dds == doctest::Approx(2 / 0.3));
  CHECK(evaluate(triangle, find_acceleration_jumps(triangle)[0], Side::after).dds == doctest::Approx(-2 / 0.7));
}

TEST_CASE("ramps of one half make bang-bang") {
  for (int i = 0; i <= 64; ++i) {
    const double tau = i / 64.0;
    for (const Side side : {Side::before, Side::after}) {
      const MotionLawValue a = evaluate({MotionLawKind::trapezoidal_velocity, 0.5, 0.5}, tau, side);
      const MotionLawValue b = evaluate({MotionLawKind::bang_bang}, tau, side);
      CHECK(a.s == b.s);
      CHECK(a.ds == b.ds);
      CHECK(a.dds == b.dds);
    }
  }
}

TEST_CASE("only bang-bang and trapezoidal velocities jump inside") {
  for (const auto& [name, law] : all_laws()) {
    CAPTURE(name);
    const bool jumpy = law.kind == MotionLawKind::bang_bang || law.kind == MotionLawKind::trapezoidal_velocity;
    CHECK(find_acceleration_jumps(law).empty() == !jumpy);
    for (const double jump : find_acceleration_jumps(law)) {
      CHECK(jump > 0);
      CHECK(jump < 1);
      CHECK(std::abs(evaluate(law, jump, Side::before).dds - evaluate(law, jump, Side::after).dds) > 1);
    }
  }
}

TEST_CASE("ramps that no trapezium can have are refused") {
  CHECK_NOTHROW(validate({MotionLawKind::trapezoidal_velocity, 0.3, 0.7}));
  CHECK_NOTHROW(validate({MotionLawKind::cycloidal, 5, 5}));  // not its business
  CHECK_THROWS_AS(validate({MotionLawKind::trapezoidal_velocity, 0, 0.5}), std::invalid_argument);
  CHECK_THROWS_AS(validate({MotionLawKind::trapezoidal_velocity, 0.5, 1}), std::invalid_argument);
  CHECK_THROWS_AS(validate({MotionLawKind::trapezoidal_velocity, 0.5, NAN}), std::invalid_argument);
  CHECK_THROWS_AS(validate({MotionLawKind::trapezoidal_velocity, 0.6, 0.5}), std::invalid_argument);
}

}  // namespace motion_law_test
