#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <map>

using namespace balance;

namespace {

/// One moving body that carries a disc about an oblique axis.
Mechanism carrier(SpaceKind space) {
  Mechanism m;
  m.space = space;
  m.bodies.resize(2);
  m.bodies[1].name = "link";
  m.discs.resize(1);
  m.discs[0].name = "d";
  m.discs[0].body = 1;
  if (space == SpaceKind::spatial) m.discs[0].axis = Vector3(1, 2, 2) / 3;
  return m;
}

bool holds(SpaceKind space, const std::map<std::string, double>& coefficients) {
  const Mechanism m = carrier(space);
  Conditions c;
  c.parameters = dynamics::list_parameters(m);
  c.matrix = MatrixX::Zero(1, static_cast<Eigen::Index>(c.parameters.size()));
  std::size_t placed = 0;
  for (std::size_t p = 0; p < c.parameters.size(); ++p) {
    const auto found = coefficients.find(c.parameters[p].name);
    if (found == coefficients.end()) continue;
    c.matrix(0, static_cast<Eigen::Index>(p)) = found->second;
    ++placed;
  }
  REQUIRE(placed == coefficients.size());
  return is_met_by_symmetric_discs(c, 0, m);
}

}  // namespace

TEST_CASE("a disc's centre of mass lies on its axis by definition, its mass and inertia are free") {
  CHECK(holds(SpaceKind::planar, {{"d.mx", 1}}));
  CHECK(holds(SpaceKind::planar, {{"d.my", 1}, {"d.mx", -3}}));
  CHECK_FALSE(holds(SpaceKind::planar, {{"d.m", 1}}));
  CHECK_FALSE(holds(SpaceKind::planar, {{"d.J", 1}}));
  CHECK_FALSE(holds(SpaceKind::planar, {{"d.mx", 1}, {"d.m", 1e-3}}));
}

TEST_CASE("what other bodies have a part in is no matter of definition") {
  CHECK_FALSE(holds(SpaceKind::planar, {{"link.mx", 1}}));
  CHECK_FALSE(holds(SpaceKind::planar, {{"link.mx", 1}, {"d.mx", 1}}));
}

TEST_CASE("a disc's inertia is the same in all directions across its axis") {
  // I = t + (a - t) u uT with u = (1, 2, 2)/3: Iyy = Izz, Ixy = Ixz, 2 Ixy = Iyz, since off-diagonal entries go with u_i u_j.
  CHECK(holds(SpaceKind::spatial, {{"d.Iyy", 1}, {"d.Izz", -1}}));
  CHECK(holds(SpaceKind::spatial, {{"d.Ixy", 1}, {"d.Ixz", -1}}));
  CHECK(holds(SpaceKind::spatial, {{"d.Ixy", 2}, {"d.Iyz", -1}}));
  CHECK_FALSE(holds(SpaceKind::spatial, {{"d.Ixx", 1}, {"d.Iyy", -1}}));
  CHECK_FALSE(holds(SpaceKind::spatial, {{"d.Ixy", 1}}));
  CHECK(holds(SpaceKind::spatial, {{"d.mz", 1}}));
}
