// Laws of mechanics at single states, each by a second route.

#include "every_config.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace single_state_laws_test {

namespace {

using namespace balance;
using namespace balance::dynamics;

const char* const machines[] = {
    "rr.yaml",           "planar-rrr.yaml",      "spatial-rrr.yaml",  "scara.yaml",
    "four-bar.yaml",     "slider-crank.yaml",    "5r.yaml",           "3rrr.yaml",
    "delta.yaml",        "stewart.yaml",         "bricard.yaml",      "rccc.yaml",
    "spring-press.yaml", "geared-five-bar.yaml", "watt-six-bar.yaml", "spatial-slider-crank.yaml"};

/// Somewhere near the configuration in which the mechanism is assembled.
struct State {
  VectorX q, dq, ddq;
};

VectorX wave(Eigen::Index n, double phase) {
  VectorX v(n);
  for (Eigen::Index k = 0; k < n; ++k) v[k] = std::sin(1.7 * static_cast<double>(k + 1) + phase);
  return v;
}

/// @return a state that the door has an answer for
State some_state(InverseDynamics& door, double phase) {
  const auto n = static_cast<Eigen::Index>(door.degrees_of_freedom());
  VectorX rough = VectorX::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k)
    for (const CoordinateValue& value : door.mechanism().assembly)
      if (door.mechanism().coordinates[static_cast<std::size_t>(value.coordinate)].name ==
          door.independent()[static_cast<std::size_t>(k)])
        rough[k] = value.value;
  for (double reach = 0.2; reach > 1e-3; reach /= 2) {
    State state{rough + reach * wave(n, phase), wave(n, phase + 1), 3 * wave(n, phase + 2)};
    if (door.assemble(state.q) && door.at(state.q, state.dq, state.ddq)) return state;
  }
  FAIL("no state");
  return {};
}

/// @param size of the terms that both are sums of, where they cancel
void check_near(const MatrixX& a, const MatrixX& b, double tolerance, const std::string& what, double size = 0) {
  CAPTURE(what);
  REQUIRE(a.rows() == b.rows());
  REQUIRE(a.cols() == b.cols());
  size = std::max({size, a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()});
  CHECK((a - b).cwiseAbs().maxCoeff() <= tolerance * size);
}

/// ½ q̇ᵀ M q̇ by polarisation, from the energies of three states: exact for a quadratic form.
MatrixX mass_by_energy(InverseDynamics& door, const State& state) {
  const Eigen::Index n = state.q.size();
  const auto energy = [&](const VectorX& dq) { return door.at(state.q, dq, VectorX::Zero(n)).value.kinetic_energy; };
  MatrixX M(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const VectorX a = VectorX::Unit(n, i), b = VectorX::Unit(n, j);
      M(i, j) = i == j ? 2 * energy(a) : energy(a + b) - energy(a) - energy(b);
    }
  return M;
}

/// Generalised forces along the independent coordinates that the actuators exert: their power per unit rate of one coordinate.
VectorX exerted(InverseDynamics& door, const State& state, const VectorX& effort) {
  const Eigen::Index n = state.q.size();
  VectorX forces(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Sample there = door.at(state.q, VectorX::Unit(n, k), VectorX::Zero(n)).value;
    forces[k] = 0;
    for (std::size_t a = 0; a < door.mechanism().actuators.size(); ++a)
      forces[k] += effort[static_cast<Eigen::Index>(a)] * there.velocity[door.mechanism().actuators[a]];
  }
  return forces;
}

}  // namespace

TEST_CASE("the mass matrix is that of the kinetic energy") {
  for (const std::string machine : machines) {
    CAPTURE(machine);
    InverseDynamics door(doors::config(machine).mechanism);
    const State state = some_state(door, 0.4);
    const auto M = door.mass_matrix(state.q);
    REQUIRE(M);
    check_near(M.value, mass_by_energy(door, state), 1e-10, "M");
  }
}

TEST_CASE("mass matrix times accelerations and the bias are what the actuators exert") {
  for (const std::string machine : machines) {
    CAPTURE(machine);
    InverseDynamics door(doors::config(machine).mechanism);
    const State state = some_state(door, 1.1);
    const auto M = door.mass_matrix(state.q);
    const auto h = door.bias(state.q, state.dq);
    const auto all = door.at(state.q, state.dq, state.ddq);
    REQUIRE(M);
    REQUIRE(h);
    REQUIRE(all);
    check_near(M.value * state.ddq + h.value, exerted(door, state, all.value.effort), 1e-9, "M q̈ + h");
  }
}

TEST_CASE("the regressor times the parameters is efforts, shaking force and moment") {
  for (const std::string machine : machines) {
    CAPTURE(machine);
    InverseDynamics door(doors::config(machine).mechanism, {.independent = {}, .about = {0.3, -0.2, 0}});
    const State state = some_state(door, 2.3);
    const auto Y = door.regressor(state.q, state.dq, state.ddq);
    const auto all = door.at(state.q, state.dq, state.ddq);
    REQUIRE(Y);
    REQUIRE(all);
    REQUIRE(static_cast<Eigen::Index>(Y.value.parameters.size()) == Y.value.effort.cols());
    check_near(Y.value.effort * Y.value.values + Y.value.constant_effort, all.value.effort, 1e-9, "effort");
    const Eigen::Index axes = Y.value.shaking_force.rows(), turns = Y.value.shaking_moment.rows();
    const auto terms = [&](const MatrixX& matrix) {
      return (matrix.cwiseAbs() * Y.value.values.cwiseAbs()).maxCoeff();
    };
    check_near(Y.value.shaking_force * Y.value.values, all.value.shaking_force.head(axes), 1e-9, "force",
               terms(Y.value.shaking_force));
    check_near(Y.value.shaking_moment * Y.value.values, all.value.shaking_moment.tail(turns), 1e-9, "moment",
               terms(Y.value.shaking_moment));
  }
}

TEST_CASE("a parameter's column is what its change does") {
  balance::Mechanism m = doors::config("spatial-rrr.yaml").mechanism;
  InverseDynamics before(m);
  const State state = some_state(before, 0.7);
  const auto Y = before.regressor(state.q, state.dq, state.ddq);
  REQUIRE(Y);
  const VectorX effort = before.at(state.q, state.dq, state.ddq).value.effort;
  Eigen::Index column = 0;
  while (Y.value.parameters[static_cast<std::size_t>(column)].name != m.bodies[2].name + ".Izz") ++column;
  m.bodies[2].inertia(2, 2) += 0.001;
  const VectorX after = InverseDynamics(m).at(state.q, state.dq, state.ddq).value.effort;
  check_near(after - effort, 0.001 * Y.value.effort.col(column), 1e-9, "Izz");
}

TEST_CASE("the actuators' power is the rate of energy and what friction takes") {
  for (const std::string machine : machines) {
    CAPTURE(machine);
    const balance::Mechanism mechanism = doors::config(machine).mechanism;
    if (!mechanism.loads.empty()) continue;  // they have power, too
    InverseDynamics door(mechanism);
    const State state = some_state(door, 0.9);
    const balance::Sample here = door.at(state.q, state.dq, state.ddq).value;
    const auto energy = [&](double t) {  // q̈ stays: the energy's rate is exact at t = 0
      const VectorX q = state.q + t * state.dq + t * t / 2 * state.ddq, dq = state.dq + t * state.ddq;
      const balance::Sample there = door.at(q, dq, state.ddq).value;
      return there.kinetic_energy + there.potential_energy;
    };
    constexpr double h = 2e-4;
    const double rate =
        (45 * (energy(h) - energy(-h)) - 9 * (energy(2 * h) - energy(-2 * h)) + (energy(3 * h) - energy(-3 * h))) /
        (60 * h);
    double taken = 0;
    for (const balance::Friction& friction : mechanism.friction) {
      const double v = here.velocity[friction.coordinate];
      taken += friction.viscous * v * v + friction.coulomb * std::abs(v);
    }
    const double size = here.power.cwiseAbs().sum() + std::abs(rate) + taken;
    CHECK(std::abs(here.power.sum() - rate - taken) <= 1e-7 * size);  // differences of energies, order six
  }
}

TEST_CASE("the mass matrix of a four-bar is what its velocities say by hand") {
  // ground 1 m, crank 0.3, coupler 0.9, rocker 0.6; uniform rods of 1 kg per metre
  constexpr double ground_link = 1, a = 0.3, b = 0.9, c = 0.6;
  const auto rod = [](const char* name, double length) {
    return balance::Body{.name = name,
                         .mass = length,
                         .com = {length / 2, 0, 0},
                         .inertia = Vector3(0, 0, length * length * length / 12).asDiagonal(),
                         .points = {}};
  };
  balance::Mechanism m;
  m.name = "four-bar";
  m.bodies = {{.name = "ground"}, rod("crank", a), rod("coupler", b), rod("rocker", c)};
  m.joints = {{.name = "A", .first = 0, .second = 1},
              {.name = "B", .first = 1, .second = 2, .point_first = {a, 0, 0}},
              {.name = "D", .first = 0, .second = 3, .point_first = {ground_link, 0, 0}},
              {.name = "C", .first = 2, .second = 3, .point_first = {b, 0, 0}, .point_second = {c, 0, 0}}};
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {0};
  m.assembly = {{2, 1.9}};
  InverseDynamics door(m);
  CHECK(door.degrees_of_freedom() == 1);
  for (const double crank : {0.5, 1.5, 3.0, 5.0}) {
    const VectorX q = VectorX::Constant(1, crank);
    const auto M = door.mass_matrix(q);
    REQUIRE(M);
    // the rocker's angle from the triangle over the diagonal, open branch
    const Vector2 B(a * std::cos(crank), a * std::sin(crank)), D(ground_link, 0);
    const double diagonal = (B - D).norm(), to_B = std::atan2(B.y(), B.x() - ground_link);
    const double rocker = to_B - std::acos((diagonal * diagonal + c * c - b * b) / (2 * diagonal * c));
    const Vector2 C = D + c * Vector2(std::cos(rocker), std::sin(rocker));
    const double coupler = std::atan2(C.y() - B.y(), C.x() - B.x());
    // rates per unit rate of the crank: velocity of C along the coupler and across it
    const double coupler_rate = a * std::sin(rocker - crank) / (b * std::sin(coupler - rocker));
    const double rocker_rate = a * std::sin(crank - coupler) / (c * std::sin(rocker - coupler));
    const Vector2 G = a * Vector2(-std::sin(crank), std::cos(crank)) +
                      b / 2 * coupler_rate * Vector2(-std::sin(coupler), std::cos(coupler));
    const double by_hand = a * a * a / 3 + b * G.squaredNorm() + b * b * b / 12 * coupler_rate * coupler_rate +
                           c * c * c / 3 * rocker_rate * rocker_rate;
    CHECK(std::abs(M.value(0, 0) - by_hand) <= 1e-11 * by_hand);
  }
}

}  // namespace single_state_laws_test
