// Andrews' squeezing mechanism against the published test-set solution.
// Source: test set for IVP solvers (University of Bari), problem "Andrews' squeezing mechanism": start, accelerations at the start,
// and the state at t = 0.03 s.

#include "plant_cases.hpp"

#include <map>

using namespace plants;

namespace {

struct Published {
  const char* name;
  double start, position, velocity;
};

// clang-format off
constexpr Published angles[] = {
    {"beta",   -0.0617138900142764496, 0.1581077119629904e2,  0.1139920302151208e4},
    {"theta",   0,                    -0.1575637105984298e2, -0.1424379294994111e4},
    {"gamma",   0.455279819163070380,  0.4082224013073101e-1, 0.1103291221937134e2},
    {"phi",     0.222668390165885885, -0.5347301163226948,    0.1929337464421385e2},
    {"delta",   0.487364979543842550,  0.5244099658805304,    0.5735699284790808},
    {"omega",  -0.222668390165885885,  0.5347301163226948,   -0.1929337464421385e2},
    {"epsilon", 1.23054744454982119,   0.1048080741042263e1,  0.3231791658026955}};
// clang-format on

Eigen::Index index_of(const Mechanism& mechanism, const std::string& name) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (mechanism.coordinates[c].name == name) return static_cast<Eigen::Index>(c);
  FAIL("no coordinate " << name);
  return 0;
}

Known rest(const Mechanism& mechanism) {
  Known state;
  state.q = state.dq = VectorX::Zero(static_cast<Eigen::Index>(mechanism.coordinates.size()));
  for (const Published& angle : angles) state.q[index_of(mechanism, angle.name)] = angle.start;
  return state;
}

}  // namespace

TEST_CASE("the squeezing mechanism starts with the published accelerations") {
  const Mechanism mechanism = config("squeezer.yaml").mechanism;
  const Known state = rest(mechanism);
  dynamics::ForwardDynamics forward(mechanism);
  REQUIRE(forward.set_state(0, state.q, state.dq).status == MotionStatus::done);
  CHECK(forward.freedoms() == 1);
  CHECK((forward.position() - state.q).head(7).cwiseAbs().maxCoeff() < 1e-14);  // the published angles close the loops
  const VectorX ddq = forward.acceleration(nothing(mechanism));
  CHECK(ddq[index_of(mechanism, "beta")] == doctest::Approx(14222.4439199541138).epsilon(1e-12));
  CHECK(ddq[index_of(mechanism, "theta")] == doctest::Approx(-10666.8329399655854).epsilon(1e-12));
  for (const char* name : {"gamma", "phi", "delta", "omega", "epsilon"})
    CHECK(std::abs(ddq[index_of(mechanism, name)]) < 1e-7);
}

TEST_CASE("the squeezing mechanism arrives where the test set says, after two and a half turns of the crank") {
  const Mechanism mechanism = config("squeezer.yaml").mechanism;
  const Known state = rest(mechanism);
  PlantOptions options;
  options.relative_tolerance = options.absolute_tolerance = 1e-14;
  Plant plant(mechanism, options);
  REQUIRE(plant.start(0, state.q, state.dq).status == MotionStatus::done);
  const double start = plant.observe(nothing(mechanism)).potential_energy;
  const MotionOutcome outcome = plant.advance(0.03, nothing(mechanism));
  REQUIRE_MESSAGE(outcome.status == MotionStatus::done, outcome.reason);
  double position = 0, velocity = 0;
  for (const Published& angle : angles) {
    const Eigen::Index c = index_of(mechanism, angle.name);
    position = std::max(position, std::abs(plant.position()[c] - angle.position));
    velocity = std::max(velocity, std::abs(plant.velocity()[c] - angle.velocity) / 1e3);
  }
  // Of the published state, T + V − torque · beta is 2.2e-10 J less than at the start: it is good to about ten digits.
  CHECK(position < 2e-9);
  CHECK(velocity < 1e-9);
  const Sample& seen = plant.observe(nothing(mechanism));
  const auto beta = index_of(mechanism, "beta");
  const double left = seen.kinetic_energy + seen.potential_energy - 0.033 * (plant.position()[beta] - angles[0].start);
  CHECK(std::abs(left - start) < 1e-12);
  CHECK(seen.closure_residual < 1e-11);
  MESSAGE("angles within " << position << " rad, rates within " << velocity << " of 1000 rad/s; "
                           << plant.cost().evaluations << " evaluations, " << plant.cost().choices << " choices");
}
