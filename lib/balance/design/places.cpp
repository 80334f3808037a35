#include "balance/design/places.hpp"

#include "balance/base/elementary.hpp"

#include <cmath>
#include <numbers>

namespace balance::design {

namespace {

/// Points per number.
constexpr int grid_points_1d = 65, grid_points_2d = 17;

}  // namespace

MatrixX grid_points(int n) {
  const int each = n == 1 ? grid_points_1d : grid_points_2d;
  const auto part = [&](int k) { return -1 + 2.0 * k / (each - 1); };
  MatrixX points(n, n == 1 ? each : each * each);
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    points(0, k) = part(static_cast<int>(k) % each);
    if (n == 2) points(1, k) = part(static_cast<int>(k) / each);
  }
  return points;
}

MatrixX direction_samples(int dimension) {
  constexpr int planar_direction_count = 32;
  if (dimension == 3) {
    MatrixX all(26, 3);
    Eigen::Index row = 0;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (const Vector3 d(z, y, x); d.norm() > 0) all.row(row++) = d.normalized();
    return all;
  }
  MatrixX all(planar_direction_count, 2);
  for (int k = 0; k < planar_direction_count; ++k) {
    const double angle = 2 * std::numbers::pi * k / planar_direction_count;
    all.row(k) << elementary::cos(angle), elementary::sin(angle);
  }
  return all;
}

}  // namespace balance::design
