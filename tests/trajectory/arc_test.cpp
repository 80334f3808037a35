#include "schedules.hpp"

#include "balance/foundation/base/rotation.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

using namespace balance;
using namespace balance::trajectory;

namespace {

constexpr double pi = std::numbers::pi;

PrescribedMotion::Request planar(Path path) {
  return {.law = {MotionLawKind::cycloidal},
          .path = std::move(path),
          .duration = 0.5,
          .from = {values({1, 0, 0.2})},
          .to = {values({-1, 0, 0.8})},
          .via = {},
          .position_components = 2};
}

PrescribedMotion::Request spatial(Path path) {
  PrescribedMotion::Request request{.law = {MotionLawKind::polynomial_345},
                                    .path = std::move(path),
                                    .duration = 1.5,
                                    .from = {values({1, 2, 3}), rotation_from_rpy({0.1, 0.2, 0.3})},
                                    .to = {values({-1, 0.5, 2}), rotation_from_rpy({1, -0.5, 0.3})},
                                    .via = {},
                                    .position_components = 3,
                                    .has_rotation = true};
  return request;
}

/// Arc length by summing speeds: Simpson's rule would do better, the trapezoidal rule on a periodic speed is exact enough.
double travelled(const PrescribedMotion& schedule, int components) {
  constexpr int steps = 20000;
  double length = 0;
  for (int i = 0; i <= steps; ++i) {
    const double weight = i == 0 || i == steps ? 0.5 : 1;
    length += weight * sample_at(schedule, schedule.duration() * i / steps).rate.head(components).norm();
  }
  return length * schedule.duration() / steps;
}

}  // namespace

TEST_CASE("an arc starts, passes and ends at its three points") {
  const PrescribedMotion half(planar(ArcPath{{0, 1, 0}}));
  CHECK((sample_at(half, 0).value - values({1, 0, 0.2})).norm() < 1e-15);  // round-off
  CHECK((sample_at(half, 0.25).value - values({0, 1, 0.5})).norm() < 1e-15);
  CHECK((sample_at(half, 0.5).value - values({-1, 0, 0.8})).norm() < 1e-15);

  const Vector3 via(0.3, 2.5, 1);
  const PrescribedMotion tilted(spatial(ArcPath{via}));
  double nearest = 1;
  for (int i = 0; i <= 20000; ++i) {
    nearest = std::min(nearest, (sample_at(tilted, 1.5 * i / 20000).value - via).norm());
  }
  CHECK(nearest < 1e-3);  // half a step at a speed below 10
  CHECK((sample_at(tilted, 1.5).value - values({-1, 0.5, 2})).norm() < 1e-14);
}

TEST_CASE("an arc turns the way its via point says") {
  CHECK(sample_at(PrescribedMotion(planar(ArcPath{{0, 1, 0}})), 0.25).value[1] == doctest::Approx(1));
  CHECK(sample_at(PrescribedMotion(planar(ArcPath{{0, -1, 0}})), 0.25).value[1] == doctest::Approx(-1));
}

TEST_CASE("an arc can be longer than half a circle") {
  PrescribedMotion::Request request = planar(ArcPath{{-1, 0, 0}});
  request.to.value = values({0, -1, 0.8});
  CHECK(travelled(PrescribedMotion(request), 2) == doctest::Approx(1.5 * pi));
  request.path = ArcPath{{std::cos(-pi / 4), std::sin(-pi / 4), 0}};
  CHECK(travelled(PrescribedMotion(request), 2) == doctest::Approx(0.5 * pi));
}

TEST_CASE("arcs and circles stay on their circle and in its plane") {
  const Vector3 start(1, 2, 3), via(0.3, 2.5, 1), end(-1, 0.5, 2);
  const Vector3 normal = (via - start).cross(end - start).normalized();
  const PrescribedMotion schedule(spatial(ArcPath{via}));
  // the centre from the definition: equal distances and in the plane, solved independently of the code
  Matrix3 equations;
  equations << (via - start).transpose(), (end - start).transpose(), normal.transpose();
  const Vector3 right((via.squaredNorm() - start.squaredNorm()) / 2, (end.squaredNorm() - start.squaredNorm()) / 2,
                      normal.dot(start));
  const Vector3 centre = equations.inverse() * right;
  const double radius = (start - centre).norm();
  for (int i = 0; i <= 100; ++i) {
    const Vector3 point = sample_at(schedule, 1.5 * i / 100).value;
    CHECK(std::abs((point - centre).norm() - radius) < 1e-14);  // round-off of lengths up to 4
    CHECK(std::abs(normal.dot(point - start)) < 1e-14);
  }
}

TEST_CASE("the derivatives of arcs and circles meet finite differences, rotations included") {
  check_derivatives(PrescribedMotion(spatial(ArcPath{{0.3, 2.5, 1}})), 3000);
  check_derivatives(PrescribedMotion(spatial(CirclePath{{0, 0, 1}, Vector3(1, 1, 2).normalized(), -2 * pi})), 3000);
  // angle 2π in 0.5 s: jerk about (4π/0.5)³ = 16,000, and its rate 25 times as much
  check_derivatives(PrescribedMotion(planar(CirclePath{{0, 0, 0}, Vector3::UnitZ(), 2 * pi})), 1e6);
}

TEST_CASE("a full circle comes back to its start and has travelled its circumference") {
  PrescribedMotion::Request request = planar(CirclePath{{0.2, 0.1, 0}, Vector3::UnitZ(), 2 * pi});
  const PrescribedMotion schedule(request);
  CHECK((sample_at(schedule, 0.5).value.head(2) - values({1, 0})).norm() < 1e-15);  // round-off
  CHECK(travelled(schedule, 2) == doctest::Approx(2 * pi * std::hypot(0.8, 0.1)));
}

TEST_CASE("a quarter of a circle turns counter-clockwise about its normal, clockwise for a negative angle") {
  const auto end = [](double normal, double angle) {
    return PrescribedMotion(planar(CirclePath{{0, 0, 0}, {0, 0, normal}, angle}));
  };
  CHECK((sample_at(end(1, pi / 2), 0.5).value.head(2) - values({0, 1})).norm() < 1e-15);
  CHECK((sample_at(end(1, -pi / 2), 0.5).value.head(2) - values({0, -1})).norm() < 1e-15);
  CHECK((sample_at(end(-1, pi / 2), 0.5).value.head(2) - values({0, -1})).norm() < 1e-15);
}

TEST_CASE("a circle about an axis away from the start keeps the distance along the axis") {
  PrescribedMotion::Request request = spatial(CirclePath{{0, 0, 7}, Vector3::UnitZ(), 3 * pi});
  const PrescribedMotion schedule(request);
  for (int i = 0; i <= 20; ++i) {
    const DriveSample sample = sample_at(schedule, 1.5 * i / 20);
    CHECK(sample.value[2] == doctest::Approx(3));
    CHECK(sample.value.head(2).norm() == doctest::Approx(std::sqrt(5.0)));
  }
  CHECK((sample_at(schedule, 1.5).value - values({-1, -2, 3})).norm() < 1e-14);
}

TEST_CASE("what does not go round a circle goes straight to its end, or stays if there is none") {
  PrescribedMotion::Request request = planar(CirclePath{{0, 0, 0}, Vector3::UnitZ(), pi});
  const PrescribedMotion schedule(request);
  CHECK(sample_at(schedule, 0.25).value[2] == doctest::Approx(0.5));
  CHECK(sample_at(schedule, 0.5).value[2] == doctest::Approx(0.8));
  request.to = {};
  CHECK(sample_at(PrescribedMotion(request), 0.25).value[2] == 0.2);
  CHECK(sample_at(PrescribedMotion(request), 0.25).rate[2] == 0);
}

TEST_CASE("circles that do not exist are refused with their reason") {
  CHECK(says(refusal(planar(ArcPath{{0, 0, 0}})), "on one line"));
  CHECK(says(refusal(planar(ArcPath{{1, 0, 0}})), "on one line"));   // via = start
  CHECK(says(refusal(planar(ArcPath{{-1, 0, 0}})), "on one line"));  // via = end
  CHECK(says(refusal(planar(ArcPath{{0, std::nan(""), 0}})), "finite"));
  CHECK(says(refusal(planar(CirclePath{{1, 0, 0}, Vector3::UnitZ(), 1})), "centre"));
  CHECK(says(refusal(planar(CirclePath{{0, 0, 0}, Vector3::UnitX(), 1})), "plane"));
  CHECK(says(refusal(planar(CirclePath{{0, 0, 0}, Vector3::Zero(), 1})), "normal"));
  CHECK(says(refusal(planar(CirclePath{{0, 0, 0}, Vector3::UnitZ(), 0})), "angle"));
  CHECK(says(refusal(spatial(CirclePath{{0, 0, 0}, Vector3(1, 2, 3), 1})), "axis"));
  for (const Path& path : {Path(CirclePath{{0, 0, 0}, Vector3::UnitZ(), 1}), Path(ArcPath{{0, 1, 0}})}) {
    PrescribedMotion::Request request = planar(path);
    request.position_components = 0;
    CHECK(says(refusal(request), "position of a point"));
  }
}
