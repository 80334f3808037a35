// The equation of motion in speeds of the user's choice, with constraints that leave more configurations than velocities.

#include "configs.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::dynamics;
using namespace equations;

namespace {

using Of = model::GeneralisedSpeedTerm::Kind;
constexpr double r = 0.1, b = 0.2;

int coordinate(const Mechanism& mechanism, const std::string& name) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (mechanism.coordinates[c].name == name) return static_cast<int>(c);
  return -1;
}

/// The contact points of the wheels stand still: forward speed ∓ b · turning − r · rate of the wheel, and no motion aside.
model::SpeedChoice rolling(const Mechanism& cart) {
  const int body = cart.tool->body;
  const Vector3 axle = cart.tool->position;
  const model::GeneralisedSpeedTerm ahead{Of::velocity_body, 0, 1, body, axle},
      aside{Of::velocity_body, 1, 1, body, axle};
  const auto wheel = [&](const char* name, double side) {
    return model::GeneralisedSpeed{
        name, {ahead, {Of::angular_velocity_body, 2, side, body}, {Of::coordinate, coordinate(cart, name), -r}}};
  };
  return {{{"v", {ahead}}, {"w", {{Of::angular_velocity_body, 2, 1, body}}}},
          {wheel("A", -b), wheel("B", b), {"side", {aside}}}};
}

}  // namespace

TEST_CASE("a cart whose wheels roll has the equation of a unicycle in its forward speed and its turning") {
  const Mechanism cart = doors::config("poses/cart-two-wheels.yaml").mechanism;
  EquationTerms terms(cart, {.independent = {"P.x", "P.y", "P.angle", "A", "B"}});
  const double heading = 0.8, d = 0.15, body = 8, wheel = 0.7, spin = 0.0035, across = 0.002;
  VectorX q(5);
  q << 0.3, -0.2, heading, 1, 2;
  const Expected<SpeedTerms> found = terms.speed_terms(q, rolling(cart));
  REQUIRE(found);
  const IndependentTerms& own = found.value.speed_equations;
  // round-off of sums of terms of the order 10
  constexpr double tolerance = 1e-13;
  CHECK(own.mass(0, 0) == doctest::Approx(body + 2 * wheel + 2 * spin / (r * r)).epsilon(tolerance));
  const double turning = 0.25 + body * d * d + 2 * (across + wheel * b * b) + 2 * spin * b * b / (r * r);
  CHECK(own.mass(1, 1) == doctest::Approx(turning).epsilon(tolerance));
  CHECK(std::abs(own.mass(0, 1)) < 1e-13);
  // F = m v' − m_c d w², M = I w' + m_c d v w
  MatrixX ahead(2, 2), around(2, 2);
  ahead << 0, 0, 0, -body * d;
  around << 0, body * d / 2, body * d / 2, 0;
  CHECK(largest(own.velocity[0] - ahead) < 1e-12);
  CHECK(largest(own.velocity[1] - around) < 1e-12);
  CHECK(largest(own.static_terms.sum()) < 1e-12);
  // the wheels roll: rates of x, y, heading and both wheels
  MatrixX rates(5, 2);
  rates << std::cos(heading), 0, std::sin(heading), 0, 0, 1, 1 / r, -b / r, 1 / r, b / r;
  CHECK(largest(found.value.rates - rates) < 1e-12);
}

TEST_CASE("speeds that do not determine the motion have no equation, and as many are needed as there are freedoms") {
  const Mechanism cart = doors::config("poses/cart-two-wheels.yaml").mechanism;
  EquationTerms terms(cart, {.independent = {"P.x", "P.y", "P.angle", "A", "B"}});
  model::SpeedChoice choice = rolling(cart);
  choice.constrained[2] = choice.speeds[0];
  CHECK(terms.speed_terms(VectorX::Zero(5), choice).outcome.status == MotionStatus::drive_singularity);
  choice.constrained.pop_back();
  CHECK_THROWS_AS(terms.speed_terms(VectorX::Zero(5), choice), std::invalid_argument);
}
