#include "schedules.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace line_test {

using namespace balance;
using namespace balance::trajectory;

namespace {

constexpr double pi = std::numbers::pi;

PrescribedMotion::Request line(MotionLawKind kind) {
  return {.law = {kind},
          .path = LinePath{},
          .duration = 0.1,
          .from = {values({-0.1, -0.05, 0.3})},
          .to = {values({0.1, 0.05, -0.2})},
          .via = {},
          .position_components = 2};
}

}  // namespace

TEST_CASE("on a line every component goes with the law") {
  const PrescribedMotion::Request request = line(MotionLawKind::cycloidal);
  const PrescribedMotion schedule(request);
  CHECK(schedule.duration() == 0.1);
  CHECK(schedule.component_count() == 3);
  CHECK(schedule.jump_times().empty());
  const VectorX delta = request.to.value - request.from.value;
  for (int i = 0; i <= 10; ++i) {
    const double tau = i / 10.0;
    const DriveSample sample = sample_at(schedule, 0.1 * tau);
    // P3 eq. 52 and its time derivatives; round-off of values up to 1, 10 and 1000
    CHECK((sample.value - request.from.value - (tau - std::sin(2 * pi * tau) / (2 * pi)) * delta).norm() < 1e-15);
    CHECK((sample.rate - (1 - std::cos(2 * pi * tau)) / 0.1 * delta).norm() < 1e-13);
    CHECK((sample.acceleration - 2 * pi * std::sin(2 * pi * tau) / 0.01 * delta).norm() < 1e-11);
  }
  CHECK(sample_at(schedule, 0).value == request.from.value);
}

TEST_CASE("a line's derivatives meet finite differences under every law, turning or not") {
  for (const MotionLawKind kind : {MotionLawKind::cycloidal, MotionLawKind::bang_bang, MotionLawKind::uniform,
                                   MotionLawKind::cubic, MotionLawKind::polynomial_345, MotionLawKind::polynomial_4567,
                                   MotionLawKind::harmonic, MotionLawKind::trapezoidal_velocity}) {
    CAPTURE(static_cast<int>(kind));
    PrescribedMotion::Request request = line(kind);
    request.duration = 2;
    request.has_rotation = true;
    request.from.rotation = rotation_from_rpy({0.3, -0.4, 1});
    request.to.rotation = rotation_from_rpy({-1, 0.8, 2.5});
    check_derivatives(PrescribedMotion(request), 1000);  // fourth derivative of 4-5-6-7 below 900 / 2⁴ times 2.4 rad
  }
}

TEST_CASE("samples of a uniform grid that fall on a jump are on the side that is asked for") {
  for (const double duration : {0.1, 0.3, 0.7, 1.0, 1.1, 3.3, 1e-4, 86400.0}) {
    for (const long samples : {3L, 101L, 1001L, 2001L, 4097L, 100001L}) {
      CAPTURE(duration);
      CAPTURE(samples);
      PrescribedMotion::Request request = line(MotionLawKind::bang_bang);
      request.duration = duration;
      const PrescribedMotion schedule(request);
      const long k = (samples - 1) / 2;
      const double step = duration / static_cast<double>(samples - 1);
      const double acceleration = 4 * 0.2 / (duration * duration);
      for (const double time :
           {static_cast<double>(k) * duration / static_cast<double>(samples - 1), static_cast<double>(k) * step,
            schedule.jump_times().at(0), std::nextafter(duration / 2, 0.0), std::nextafter(duration / 2, duration)}) {
        CHECK(sample_at(schedule, time, Side::before).acceleration[0] == doctest::Approx(acceleration));
        CHECK(sample_at(schedule, time, Side::after).acceleration[0] == doctest::Approx(-acceleration));
      }
      // the neighbouring samples are on their own side of the jump
      const double left = static_cast<double>(k - 1) * step, right = static_cast<double>(k + 1) * step;
      CHECK(sample_at(schedule, left, Side::after).acceleration[0] > 0);
      CHECK(sample_at(schedule, right, Side::before).acceleration[0] < 0);
    }
  }
}

TEST_CASE("the jumps of a trapezoidal velocity keep their sides at rounded times") {
  PrescribedMotion::Request request = line(MotionLawKind::trapezoidal_velocity);
  request.law.ramp_up = 0.1;
  request.law.ramp_down = 0.3;
  request.duration = 0.7;
  const PrescribedMotion schedule(request);
  REQUIRE(schedule.jump_times().size() == 2);
  for (const double time : {0.7 * 100 / 1000, 0.7 / 1000 * 100, schedule.jump_times()[0]}) {
    CHECK(sample_at(schedule, time, Side::before).acceleration[0] > 1);
    CHECK(sample_at(schedule, time, Side::after).acceleration[0] == 0);
  }
  for (const double time : {0.7 * 700 / 1000, 0.7 / 1000 * 700, schedule.jump_times()[1]}) {
    CHECK(sample_at(schedule, time, Side::before).acceleration[0] == 0);
    CHECK(sample_at(schedule, time, Side::after).acceleration[0] < -1);
  }
}

TEST_CASE("at the ends of a motion the inner acceleration holds on both sides") {
  const PrescribedMotion schedule(line(MotionLawKind::bang_bang));
  for (const Side side : {Side::before, Side::after}) {
    CHECK(sample_at(schedule, 0, side).acceleration[0] == doctest::Approx(80));
    CHECK(sample_at(schedule, 0.1, side).acceleration[0] == doctest::Approx(-80));
    CHECK(sample_at(schedule, 1000 * (0.1 / 1000), side).acceleration[0] == doctest::Approx(-80));
  }
}

TEST_CASE("a motion that goes nowhere has no jumps") {
  PrescribedMotion::Request request = line(MotionLawKind::bang_bang);
  request.to = request.from;
  CHECK(PrescribedMotion(request).jump_times().empty());
}

TEST_CASE("a turn takes the shortest rotation about one axis of the world") {
  PrescribedMotion::Request request = line(MotionLawKind::uniform);
  const Vector3 axis = Vector3(1, -2, 0.5).normalized();
  request.has_rotation = true;
  request.from.rotation = rotation_from_rpy({0.3, -0.4, 1});
  request.to.rotation = rotation_about(axis, 3) * request.from.rotation;
  request.duration = 2;
  const PrescribedMotion schedule(request);
  for (int i = 0; i <= 10; ++i) {
    const DriveSample sample = sample_at(schedule, 0.2 * i);
    CHECK((sample.rotation - rotation_about(axis, 0.3 * i) * request.from.rotation).norm() < 1e-14);  // round-off
    CHECK((sample.angular_velocity - 1.5 * axis).norm() < 1e-14);
    CHECK(sample.angular_acceleration.norm() < 1e-14);
  }
}

TEST_CASE("a turn alone, without scalars, is a motion") {
  PrescribedMotion::Request request;
  request.has_rotation = true;
  request.to.rotation = rotation_about(Vector3::UnitY(), -1);
  const PrescribedMotion schedule(request);
  CHECK(schedule.component_count() == 0);
  CHECK((sample_at(schedule, 1).rotation - request.to.rotation).norm() < 1e-15);
  check_derivatives(schedule, 250);  // (2π)³ of the cycloid
}

TEST_CASE("a schedule that does not turn leaves no rotation of another one in the sample") {
  DriveSample sample;
  sample.rotation = rotation_about(Vector3::UnitX(), 1);
  sample.angular_velocity = Vector3(1, 2, 3);
  PrescribedMotion(line(MotionLawKind::cycloidal)).at(0.05, Side::after, sample);
  CHECK(sample.rotation == Matrix3::Identity());
  CHECK(sample.angular_velocity == Vector3::Zero());
}

TEST_CASE("evaluation keeps the sample's memory") {
  const PrescribedMotion schedule(line(MotionLawKind::cycloidal));
  DriveSample sample = sample_at(schedule, 0);
  const double* memory = sample.value.data();
  schedule.at(0.07, Side::before, sample);
  CHECK(sample.value.data() == memory);
}

TEST_CASE("times outside the motion are refused, round-off at its ends is not") {
  const PrescribedMotion schedule(line(MotionLawKind::cycloidal));
  CHECK(sample_at(schedule, 0.1 * (1 + 1e-12)).value == sample_at(schedule, 0.1).value);
  CHECK(sample_at(schedule, -1e-13).value == sample_at(schedule, 0).value);
  for (const double time : {-0.001, 0.101, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_THROWS_AS(sample_at(schedule, time), std::invalid_argument);
  }
}

TEST_CASE("what no motion can be is refused with its reason") {
  const auto changed = [](auto change) {
    PrescribedMotion::Request request = line(MotionLawKind::cycloidal);
    change(request);
    return refusal(request);
  };
  CHECK(refusal(line(MotionLawKind::cycloidal)).empty());
  CHECK(says(changed([](auto& r) { r.duration = 0; }), "duration"));
  CHECK(says(changed([](auto& r) { r.duration = std::nan(""); }), "duration"));
  CHECK(says(changed([](auto& r) { r.to.value = values({1}); }), "starts with 3 values, but the end has 1 value"));
  CHECK(says(changed([](auto& r) { r.from.value[1] = std::nan(""); }), "the start"));
  CHECK(says(changed([](auto& r) { r.to.value[1] = INFINITY; }), "the end"));
  CHECK(says(changed([](auto& r) { r.law = {MotionLawKind::trapezoidal_velocity, 0.8, 0.8}; }), "ramps"));
  CHECK(says(changed([](auto& r) { r.position_components = 4; }), "coordinates of a point"));
  CHECK(says(changed([](auto& r) { r.from = r.to = {}, r.position_components = 0; }), "prescribes nothing"));
  CHECK(says(changed([](auto& r) { r.has_rotation = true, r.to.rotation *= 1.1; }), "orientation at the end"));
  CHECK(says(changed([](auto& r) { r.has_rotation = true, r.from.rotation *= -1; }), "orientation at the start"));
}

}  // namespace line_test
