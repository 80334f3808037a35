#include "balance/mechanics/model/force_table.hpp"

#include "balance/foundation/numerics/cubic_spline.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace {

using balance::model::ForceLawOf;
using balance::model::ForceTableOf;
using balance::model::TableInterpolation;

const ForceTableOf<double> rows{{0.1, 0.3, 0.35, 0.8, 1.2}, {-40, -10, 5, 60, 70}, TableInterpolation::linear};

ForceTableOf<double> as_spline() {
  ForceTableOf<double> table = rows;
  table.interpolation = TableInterpolation::spline;
  return table;
}

}  // namespace

TEST_CASE("a table is linear between its rows and constant beyond them") {
  const ForceLawOf<double> law(rows);
  CHECK(law.force(0.2) == doctest::Approx(-25).epsilon(1e-15));
  CHECK(law.force(0.0) == -40);
  CHECK(law.force(5.0) == 70);
  CHECK(law.force(0.3) == doctest::Approx(-10).epsilon(1e-15));
  CHECK(law.max_force() == 70);
}

TEST_CASE("the spline is the not-a-knot spline of numerics") {
  const ForceLawOf<double> law(as_spline());
  balance::Samples values(5, 1);
  for (int k = 0; k < 5; ++k) values(k, 0) = rows.force[static_cast<std::size_t>(k)];
  const balance::numerics::CubicSpline spline(rows.displacement, values, balance::numerics::SplineEnd::not_a_knot);
  balance::VectorX value(1), first(1), second(1);
  for (double x = 0.1; x <= 1.2; x += 0.01) {
    spline.at(x, value, first, second);
    CHECK(law.force(x) == doctest::Approx(value[0]).epsilon(1e-12));  // slopes against second derivatives: round-off
  }
}

TEST_CASE("the energy's derivative is the force") {
  for (const auto& table : {rows, as_spline()}) {
    const ForceLawOf<double> law(table);
    CHECK(law.energy(0.1) == 0);
    for (double x = -0.2; x < 1.6; x += 0.037) {
      constexpr double h = 1e-4;  // exact for cubics, but for round-off of the difference: 1e-16 · 50 / 1e-4
      const double slope =
          (law.energy(x - 2 * h) - 8 * law.energy(x - h) + 8 * law.energy(x + h) - law.energy(x + 2 * h)) / (12 * h);
      bool is_near_row = false;
      for (const double row : table.displacement) is_near_row = is_near_row || std::abs(x - row) < 3 * h;
      if (!is_near_row) CHECK(slope == doctest::Approx(law.force(x)).epsilon(1e-9));
    }
  }
}
