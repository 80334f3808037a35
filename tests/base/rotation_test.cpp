#include "balance/foundation/base/rotation.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace balance;

TEST_CASE("a frame along a direction is a rotation to round-off, however nearly the direction is opposite to z") {
  for (int decade = 0; decade <= 30; ++decade)
    for (const double side : {1.0, -1.0})
      for (const double turn : {0.0, 0.4, 1.9, 4.0}) {
        const double sine = std::pow(10, -decade), cosine = side * std::sqrt(1 - sine * sine);
        const Vector3 direction(sine * std::cos(turn), sine * std::sin(turn), cosine);
        const Matrix3 R = frame_with_z_along(direction);
        CAPTURE(direction);
        CHECK((R.col(2) - direction).norm() <= 1e-16);
        CHECK((R.transpose() * R - Matrix3::Identity()).norm() <= 2e-15);
        CHECK(std::abs(R.determinant() - 1) <= 2e-15);
        // of all rotations that do it the one with the least angle: its axis is normal to z
        CHECK(std::abs(R(1, 0) - R(0, 1)) <= 1e-16);
      }
  CHECK(frame_with_z_along(Vector3::UnitX()).col(2) == Vector3::UnitX());
  CHECK(frame_with_z_along(-Vector3::UnitZ()).col(2) == -Vector3::UnitZ());
}
