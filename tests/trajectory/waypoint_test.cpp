#include "schedules.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace waypoint_test {

using namespace balance;
using namespace balance::trajectory;

namespace {

constexpr double pi = std::numbers::pi;

/// Chords of 3, 4 and 5; the angle does not count in them.
PrescribedMotion::Request triangle(MotionLawKind kind, bool spline, std::vector<double> fractions = {}) {
  return {.law = {kind},
          .path = WaypointPath{.points = {}, .spline = spline, .fractions = std::move(fractions)},
          .duration = 1.2,
          .from = {values({0, 0, 0})},
          .to = {values({0, 0, 1})},
          .via = {{values({3, 0, 5})}, {values({3, 4, -2})}},
          .position_components = 2};
}

PrescribedMotion::Request turning(bool spline) {
  PrescribedMotion::Request request = triangle(MotionLawKind::polynomial_345, spline);
  request.has_rotation = true;
  request.from.rotation = rotation_from_rpy({0.2, 0.1, -0.4});
  request.via[0].rotation = rotation_from_rpy({1.2, -0.5, 0.3});
  request.via[1].rotation = rotation_from_rpy({1.5, 0.6, 1.9});
  request.to.rotation = rotation_from_rpy({-0.3, 1.0, 2.5});
  return request;
}

/// A schedule of turns by the given angles about one axis, evenly spread.
PrescribedMotion::Request about(const Vector3& axis, const std::vector<double>& angles, MotionLawKind kind) {
  PrescribedMotion::Request request;
  request.law = {kind};
  request.path = WaypointPath{.points = {}, .spline = true, .fractions = {}};
  for (const double angle : angles) request.via.push_back({values({angle}), rotation_about(axis, angle)});
  request.from = request.via.front();
  request.to = request.via.back();
  request.via.pop_back();
  request.via.erase(request.via.begin());
  request.has_rotation = true;
  return request;
}

}  // namespace

TEST_CASE("with stops every waypoint is reached at rest, at its share of the chord lengths") {
  const PrescribedMotion::Request request = triangle(MotionLawKind::cycloidal, false);
  const PrescribedMotion schedule(request);
  for (const Side side : {Side::before, Side::after}) {
    CHECK((sample_at(schedule, 1.2 * 3 / 12, side).value - request.via[0].value).norm() < 1e-14);  // round-off
    CHECK((sample_at(schedule, 1.2 * 7 / 12, side).value - request.via[1].value).norm() < 1e-14);
    CHECK(sample_at(schedule, 1.2 * 3 / 12, side).rate.norm() == 0);
    CHECK(sample_at(schedule, 1.2 * 7 / 12, side).rate.norm() == 0);
  }
  CHECK((sample_at(schedule, 1.2).value - request.to.value).norm() < 1e-14);
  // half-way through the middle leg
  CHECK((sample_at(schedule, 1.2 * 5 / 12).value - values({3, 2, 1.5})).norm() < 1e-14);
}

TEST_CASE("stated fractions say when waypoints are passed, with stops and on a spline under any law") {
  for (const bool spline : {false, true}) {
    for (const MotionLawKind kind : {MotionLawKind::cycloidal, MotionLawKind::uniform, MotionLawKind::bang_bang}) {
      const PrescribedMotion::Request request = triangle(kind, spline, {0.2, 0.7});
      const PrescribedMotion schedule(request);
      CHECK((sample_at(schedule, 0.2 * 1.2).value - request.via[0].value).norm() < 1e-13);  // round-off
      CHECK((sample_at(schedule, 0.7 * 1.2).value - request.via[1].value).norm() < 1e-13);
      CHECK((sample_at(schedule, 1.2).value - request.to.value).norm() < 1e-13);
    }
  }
}

TEST_CASE("legs under a law without shock join without a jump") {
  CHECK(PrescribedMotion(triangle(MotionLawKind::cycloidal, false)).jump_times().empty());
  CHECK(PrescribedMotion(triangle(MotionLawKind::polynomial_345, false)).jump_times().empty());
  CHECK(PrescribedMotion(triangle(MotionLawKind::modified_trapezoidal, false)).jump_times().empty());
}

TEST_CASE("jumps are the ends of legs with shock and the law's own, in order of time") {
  const auto expect = [](const PrescribedMotion& schedule, const std::vector<double>& twelfths) {
    REQUIRE(schedule.jump_times().size() == twelfths.size());
    for (std::size_t i = 0; i < twelfths.size(); ++i) {
      CHECK(schedule.jump_times()[i] == doctest::Approx(1.2 * twelfths[i] / 12).epsilon(1e-14));
    }
  };
  expect(PrescribedMotion(triangle(MotionLawKind::cubic, false)), {3, 7});
  expect(PrescribedMotion(triangle(MotionLawKind::uniform, false)), {3, 7});  // the velocity jumps
  expect(PrescribedMotion(triangle(MotionLawKind::bang_bang, false)), {1.5, 3, 5, 7, 9.5});
  expect(PrescribedMotion(triangle(MotionLawKind::trapezoidal_velocity, false)), {0.75, 2.25, 3, 4, 6, 7, 8.25, 10.75});
}

TEST_CASE("uniform legs on one line with equal speeds pass their waypoint without a jump") {
  PrescribedMotion::Request request = triangle(MotionLawKind::uniform, false);
  request.via = {{values({1, 0.5, 0.1})}};
  request.to.value = values({4, 2, 0.4});
  CHECK(PrescribedMotion(request).jump_times().empty());
}

TEST_CASE("the side decides at the ends of legs, at rounded times too") {
  const PrescribedMotion schedule(triangle(MotionLawKind::cubic, false));
  for (const double time : {1.2 * 3 / 12, 300 * (1.2 / 1200), std::nextafter(schedule.jump_times()[0], 0.0),
                            std::nextafter(schedule.jump_times()[0], 1.0)}) {
    // 6 delta / leg duration²: braking along x before, speeding up along y after
    CHECK(sample_at(schedule, time, Side::before).acceleration[0] == doctest::Approx(-6 * 3 / 0.09));
    CHECK(sample_at(schedule, time, Side::before).acceleration[1] == 0);
    CHECK(sample_at(schedule, time, Side::after).acceleration[0] == 0);
    CHECK(sample_at(schedule, time, Side::after).acceleration[1] == doctest::Approx(6 * 4 / 0.16));
  }
}

TEST_CASE("a short leg in a long motion keeps the sides of its own jump") {
  PrescribedMotion::Request request = triangle(MotionLawKind::bang_bang, false, {0.6, 0.601});
  const PrescribedMotion schedule(request);
  // the middle of the short leg, reached by a grid of 2,000 steps: off by some ulp of the whole duration
  const double time = 1201 * (1.2 / 2000);
  CHECK(sample_at(schedule, time, Side::before).acceleration[1] > 0);
  CHECK(sample_at(schedule, time, Side::after).acceleration[1] < 0);
}

TEST_CASE("derivatives through waypoints meet finite differences, rotations included") {
  check_derivatives(PrescribedMotion(turning(false)),
                    3e5);  // 5-unit legs of 0.3 s: jerk up to 60 · 5 / 0.3³, its rate 1e5 and more
  check_derivatives(PrescribedMotion(turning(true)), 3e5);
  check_derivatives(PrescribedMotion(triangle(MotionLawKind::bang_bang, true)), 3e5);
}

TEST_CASE("a spline passes through its points and orientations, by chord length on the law's scale") {
  PrescribedMotion::Request request = turning(true);
  request.law = {MotionLawKind::uniform};
  const PrescribedMotion schedule(request);
  const std::vector<DriveValue> points{request.from, request.via[0], request.via[1], request.to};
  const std::vector<double> twelfths{0, 3, 7, 12};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const DriveSample sample = sample_at(schedule, 1.2 * twelfths[i] / 12);
    CHECK((sample.value - points[i].value).norm() < 1e-13);  // round-off
    CHECK((sample.rotation - points[i].rotation).norm() < 1e-13);
  }
}

TEST_CASE("acceleration and angular acceleration of a spline are continuous at its waypoints") {
  for (const MotionLawKind kind : {MotionLawKind::uniform, MotionLawKind::cycloidal}) {
    PrescribedMotion::Request request = turning(true);
    request.path = WaypointPath{.points = {}, .spline = true, .fractions = {0.3, 0.6}};
    request.law = {kind};
    const PrescribedMotion schedule(request);
    CHECK(schedule.jump_times().empty());
    for (const double knot : {0.3 * 1.2, 0.6 * 1.2}) {
      const DriveSample left = sample_at(schedule, knot - 1e-9), right = sample_at(schedule, knot + 1e-9);
      // 2e-9 s times a jerk below 1e5
      CHECK((left.acceleration - right.acceleration).norm() < 2e-4);
      CHECK((left.angular_acceleration - right.angular_acceleration).norm() < 2e-4);
      CHECK(left.acceleration.norm() > 1);  // so that the comparison says something
      CHECK(left.angular_acceleration.norm() > 1);
    }
  }
}

TEST_CASE("a spline under a law with rest starts and ends at rest") {
  const PrescribedMotion schedule(turning(true));
  for (const double time : {0.0, 1.2}) {
    CHECK(sample_at(schedule, time).rate.norm() == 0);
    CHECK(sample_at(schedule, time).acceleration.norm() == 0);
    CHECK(sample_at(schedule, time).angular_velocity.norm() == 0);
    CHECK(sample_at(schedule, time).angular_acceleration.norm() == 0);
  }
}

TEST_CASE("a spline jumps where its law does") {
  const PrescribedMotion schedule(triangle(MotionLawKind::bang_bang, true));
  REQUIRE(schedule.jump_times().size() == 1);
  CHECK(schedule.jump_times()[0] == doctest::Approx(0.6));
}

TEST_CASE("a spline through points on one line at equal shares is the line") {
  PrescribedMotion::Request request = triangle(MotionLawKind::cycloidal, true);
  request.via = {{values({1, 0.5, 0.1})}, {values({3, 1.5, 0.3})}};
  request.to.value = values({4, 2, 0.4});
  const PrescribedMotion spline(request);
  request.path = LinePath{};
  const PrescribedMotion line(request);
  for (int i = 0; i <= 100; ++i) {
    const DriveSample a = sample_at(spline, 1.2 * i / 100), b = sample_at(line, 1.2 * i / 100);
    CHECK((a.value - b.value).norm() < 1e-14);  // round-off of values up to 4, 13 and 40
    CHECK((a.rate - b.rate).norm() < 1e-13);
    CHECK((a.acceleration - b.acceleration).norm() < 1e-12);
  }
}

TEST_CASE("a spline of rotations about one axis is the spline of the angle, beyond whole turns") {
  const Vector3 axis = Vector3(2, -1, 0.5).normalized();
  const std::vector<std::vector<double>> cases{{0.3, 1.1, 0.4, -0.9},
                                               {0, 0.5 * pi, pi, 1.5 * pi, 2 * pi},
                                               {0, 0.5 * pi, 1.3 * pi, 2 * pi, 2.6 * pi, 3.4 * pi, 4 * pi},
                                               {0, 2, 4, 6, 8, 10, 12.5, 15, 17}};
  for (const std::vector<double>& angles : cases) {
    const PrescribedMotion schedule(about(axis, angles, MotionLawKind::cycloidal));
    for (int i = 0; i <= 50; ++i) {
      const DriveSample sample = sample_at(schedule, i / 50.0);
      // round-off, and 1e-12 where a whole turn leaves no axis
      CHECK((sample.rotation - rotation_about(axis, sample.value[0])).norm() < 1e-11);
      CHECK((sample.angular_velocity - sample.rate[0] * axis).norm() < 1e-10);
      CHECK((sample.angular_acceleration - sample.acceleration[0] * axis).norm() < 1e-9);
    }
  }
}

TEST_CASE("a spline of rotations run backwards is the same curve") {
  PrescribedMotion::Request request = turning(true);
  request.via.push_back({values({-1, 1, 0}), rotation_from_rpy({-0.3, 0.4, 2.2})});  // an odd number of points
  const PrescribedMotion forth(request);
  std::swap(request.from, request.to);
  std::swap(request.via.front(), request.via.back());
  const PrescribedMotion back(request);
  for (int i = 0; i <= 20; ++i) {
    const DriveSample a = sample_at(forth, 1.2 * i / 20), b = sample_at(back, 1.2 - 1.2 * i / 20);
    CHECK((a.rotation - b.rotation).norm() < 1e-12);  // round-off
    CHECK((a.angular_velocity + b.angular_velocity).norm() < 1e-11);
  }
}

TEST_CASE("a spline of orientations that wander too far is refused with its reason") {
  PrescribedMotion::Request request = turning(true);
  request.from.rotation = rotation_about(Vector3::UnitX(), 0);
  request.via = {{values({3, 0, 0}), rotation_about(Vector3::UnitX(), 2)},
                 {values({3, 4, 0}), rotation_about(Vector3::UnitX(), 4)},
                 {values({2, 4, 0}), rotation_about(Vector3::UnitX(), 6)},
                 {values({1, 4, 0}), rotation_about(Vector3::UnitX(), 8)},
                 {values({0, 4, 0}), rotation_about(Vector3::UnitX(), 10)}};
  request.to.rotation = rotation_about(Vector3::UnitY(), 1.4) * rotation_about(Vector3::UnitX(), 10);
  CHECK(says(refusal(request), "too far"));
  request.path = WaypointPath{};
  CHECK(refusal(request).empty());  // with stops every leg stands alone
}

TEST_CASE("chord lengths come from all scalars where there is no point, from rotations where nothing else moves") {
  PrescribedMotion::Request joints;
  joints.path = WaypointPath{};
  joints.from.value = values({0, 0, 0});
  joints.via = {{values({1, 2, 2})}};
  joints.to.value = values({1, 2, 3});
  CHECK((sample_at(PrescribedMotion(joints), 0.75).value - joints.via[0].value).norm() < 1e-15);

  PrescribedMotion::Request turns = joints;
  turns.has_rotation = true;
  turns.via[0] = turns.from;
  turns.to = turns.from;
  turns.via[0].rotation = rotation_about(Vector3::UnitX(), 0.5);
  turns.to.rotation = rotation_about(Vector3::UnitX(), 2.5);
  CHECK((sample_at(PrescribedMotion(turns), 0.2).rotation - turns.via[0].rotation).norm() < 1e-14);
}

TEST_CASE("a rest at a waypoint needs stated fractions and is one then") {
  PrescribedMotion::Request request = triangle(MotionLawKind::cycloidal, false);
  request.via[1].value = values({3, 0, 5});
  CHECK(says(refusal(request), "waypoint 1 and waypoint 2 coincide"));
  request.path = WaypointPath{.points = {}, .spline = false, .fractions = {0.25, 0.5}};
  const PrescribedMotion schedule(request);
  CHECK(sample_at(schedule, 0.4).value == request.via[0].value);
  CHECK(sample_at(schedule, 0.4).rate.norm() == 0);
}

TEST_CASE("waypoints that make no path are refused with their reason") {
  const auto with_fractions = [](std::vector<double> fractions, bool spline = false) {
    return refusal(triangle(MotionLawKind::polynomial_4567, spline, std::move(fractions)));
  };
  CHECK(with_fractions({0.2, 0.7}).empty());
  CHECK(says(with_fractions({0.2}), "2 waypoints, 1 fractions"));
  CHECK(says(with_fractions({0.7, 0.2}), "0.2 follows 0.7"));
  CHECK(says(with_fractions({0, 0.2}), "between 0 and 1"));
  CHECK(says(with_fractions({0.2, 1}), "between 0 and 1"));
  CHECK(says(with_fractions({0.2, std::nan("")}), "between 0 and 1"));
  CHECK(says(with_fractions({1e-4, 0.5}, true), "further apart"));  // 35e-16 of the way
  PrescribedMotion::Request request = triangle(MotionLawKind::cycloidal, true);
  request.via[1].value = values({1, 2});
  CHECK(says(refusal(request), "waypoint 2 has 2 values"));
  request.via.clear();
  CHECK(says(refusal(request), "at least one waypoint"));
}

}  // namespace waypoint_test
