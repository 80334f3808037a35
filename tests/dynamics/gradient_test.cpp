// Derivatives of what the door finds, against central differences of the door itself.

#include "every_config.hpp"

#include "balance/mechanics/derivatives/state_gradient.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

namespace {

using namespace balance;
using namespace balance::derivatives;
using namespace balance::dynamics;
using Kind = MechanismVariable::Kind;

struct State {
  VectorX q, dq, ddq;
};

/// What is compared, in one row: whatever a sample says of forces, motion and energies.
VectorX numbers_of(const Sample& s) {
  std::vector<double> all;
  const auto add = [&](const auto& values) {
    for (Eigen::Index k = 0; k < values.size(); ++k) all.push_back(values(k));
  };
  add(s.position), add(s.velocity), add(s.acceleration), add(s.effort), add(s.power), add(s.com);
  add(s.shaking_force), add(s.shaking_moment), add(s.ground_force), add(s.ground_moment);
  for (const Vector3& v : s.joint_force) add(v);
  for (const Vector3& v : s.joint_moment) add(v);
  all.push_back(s.kinetic_energy), all.push_back(s.potential_energy);
  return Eigen::Map<const VectorX>(all.data(), static_cast<Eigen::Index>(all.size()));
}

State some_state(InverseDynamics& door) {
  const auto n = static_cast<Eigen::Index>(door.degrees_of_freedom());
  State state{VectorX::Zero(n), VectorX::LinSpaced(n, 0.7, 1.3), VectorX::LinSpaced(n, -2, 3)};
  for (Eigen::Index k = 0; k < n; ++k)
    for (const CoordinateValue& value : door.mechanism().assembly)
      if (door.mechanism().coordinates[static_cast<std::size_t>(value.coordinate)].name ==
          door.independent()[static_cast<std::size_t>(k)])
        state.q[k] = value.value;
  state.q.array() += 0.05;
  return state;
}

MechanismVariable last_term(Kind kind, const model::CoordinateCombination& followed) {
  return {.kind = kind, .column = static_cast<int>(followed.terms.size()) - 1};
}

/// One of everything that the mechanism has.
std::vector<MechanismVariable> some_numbers(const Mechanism& m) {
  std::vector<MechanismVariable> all{{.kind = Kind::gravity, .row = 1},
                                     {.kind = Kind::body_mass, .index = 1},
                                     {.kind = Kind::body_com, .index = 1, .row = 1},
                                     {.kind = Kind::body_inertia, .index = 1, .row = 2, .column = 2}};
  if (m.space == SpaceKind::spatial) all.push_back({.kind = Kind::body_inertia, .index = 1, .row = 0, .column = 1});
  const int last = static_cast<int>(m.joints.size()) - 1;
  all.push_back({.kind = Kind::joint_point_second, .index = last, .row = 0});
  all.push_back({.kind = Kind::joint_point_first, .index = last, .row = 1});
  if (!m.attachments.empty()) all.push_back({.kind = Kind::attachment_position});
  if (!m.discs.empty())
    all.push_back({.kind = Kind::disc_ratio}), all.push_back(last_term(Kind::disc_term_ratio, m.discs[0].follows));
  if (!m.couplings.empty())
    all.push_back({.kind = Kind::coupling_ratio}),
        all.push_back(last_term(Kind::coupling_term_ratio, m.couplings[0].leader));
  if (!m.springs.empty()) {
    all.push_back({.kind = Kind::spring_stiffness});
    all.push_back({.kind = Kind::spring_point_second, .row = 1});
    const int in_joint = static_cast<int>(m.springs.size()) - 1;
    for (const Kind kind : {Kind::spring_stiffness, Kind::spring_preload}) all.push_back({kind, in_joint});
  }
  for (int e = 0; e < static_cast<int>(m.force_elements.size()); ++e) {
    const auto& element = m.force_elements[static_cast<std::size_t>(e)];
    if (element.is_damper())
      all.push_back({.kind = Kind::damper_damping, .index = e});
    else
      all.push_back({.kind = Kind::table_force, .index = e, .column = 1});
    if (element.is_in_joint()) continue;
    all.push_back({.kind = Kind::element_point_first, .index = e, .row = 1});
    all.push_back({.kind = Kind::element_point_second, .index = e});
  }
  if (!m.friction.empty()) all.push_back({.kind = Kind::friction_viscous});
  if (!m.loads.empty()) all.push_back({.kind = Kind::load_force});
  return all;
}

/// Fourth order: (f(−2h) − 8 f(−h) + 8 f(h) − f(2h)) / 12h.
VectorX difference(const std::function<VectorX(double)>& f, double h) {
  return (f(-2 * h) - 8 * f(-h) + 8 * f(h) - f(2 * h)) / (12 * h);
}

void check_near(const VectorX& exact, const VectorX& differences, const VectorX& here, double scale) {
  REQUIRE(exact.size() == differences.size());
  for (Eigen::Index k = 0; k < exact.size(); ++k) {
    // differences leave round-off of the terms, which is that of the largest number of this kind over the step
    const double size = std::abs(exact[k]) + exact.norm() + here.norm() / scale;
    CHECK(std::abs(exact[k] - differences[k]) <= 1e-8 * size);
  }
}

void check(const std::string& machine) {
  CAPTURE(machine);
  Mechanism mechanism = doors::config(machine).mechanism;
  for (Spring& spring : mechanism.springs)
    if (spring.stiffness == 0) spring.stiffness = 300;  // one that is still to be designed
  if (!mechanism.springs.empty())
    mechanism.springs.push_back(
        {.name = "torsion", .stiffness = 3, .preload = 0.5, .coordinate = mechanism.actuators[0]});
  InverseDynamics door(mechanism);
  const State state = some_state(door);
  std::vector<DifferentiationVariable> wanted;
  for (int k = 0; k < door.degrees_of_freedom(); ++k)
    for (const auto kind : {StateVariable::Kind::q, StateVariable::Kind::dq, StateVariable::Kind::ddq})
      wanted.emplace_back(StateVariable{kind, k});
  for (const MechanismVariable& number : some_numbers(mechanism)) wanted.emplace_back(number);
  const auto found = differentiate_state(door, state.q, state.dq, state.ddq, wanted, 0.12);
  REQUIRE_MESSAGE(found, found.outcome.reason);
  REQUIRE(found.value.derivatives.size() == wanted.size());
  const VectorX here = numbers_of(found.value.sample);
  std::vector<CoordinateGuess> near;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    near.push_back({mechanism.coordinates[c].name, found.value.sample.position[static_cast<Eigen::Index>(c)]});
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    CAPTURE(k);
    double scale = 1;
    const auto at = [&](double step) {
      State there = state;
      Mechanism changed = mechanism;
      if (const auto* own = std::get_if<StateVariable>(&wanted[k])) {
        (own->kind == StateVariable::Kind::q    ? there.q
         : own->kind == StateVariable::Kind::dq ? there.dq
                                                : there.ddq)[own->index] += step;
        const auto moved = door.at(there.q, there.dq, there.ddq, 0.12);
        REQUIRE_MESSAGE(moved, moved.outcome.reason);
        return numbers_of(moved.value);
      }
      const MechanismVariable& number = std::get<MechanismVariable>(wanted[k]);
      variable_in(changed, number) += step;
      if (has_symmetric_entry(number))
        variable_in(changed, {number.kind, number.index, number.column, number.row}) += step;
      InverseDynamics other(changed);
      REQUIRE(other.assemble(there.q, near));
      const auto moved = other.at(there.q, there.dq, there.ddq, 0.12);
      REQUIRE_MESSAGE(moved, moved.outcome.reason);
      return numbers_of(moved.value);
    };
    if (const auto* number = std::get_if<MechanismVariable>(&wanted[k])) {
      Mechanism copy = mechanism;
      const double value = std::abs(variable_in(copy, *number));
      scale =
          number->kind == Kind::body_inertia ? mechanism.bodies[1].inertia(2, 2) : std::max(0.05, std::min(1.0, value));
    }
    check_near(numbers_of(found.value.derivatives[k]), difference(at, 1e-3 * scale), here, scale);
  }
}

}  // namespace

TEST_CASE("derivatives of open chains are those of differences") {
  for (const char* machine :
       {"rr.yaml", "planar-rrr.yaml", "spatial-rrr.yaml", "scara.yaml", "spatial-rrr-design.yaml"})
    check(machine);
}

TEST_CASE("derivatives of mechanisms with loops are those of differences") {
  for (const char* machine :
       {"four-bar.yaml", "slider-crank.yaml", "3rrr.yaml", "delta.yaml", "spatial-slider-crank.yaml"})
    check(machine);
}

TEST_CASE("derivatives with springs, friction, loads and couplings are those of differences") {
  for (const char* machine :
       {"spring-press.yaml", "geared-five-bar.yaml", "spring-balancer-two-link.yaml", "planar-rrr-belts.yaml"})
    check(machine);
}

TEST_CASE("numbers that do not exist are refused") {
  InverseDynamics door(doors::config("rr.yaml").mechanism);
  const VectorX zero = VectorX::Zero(2);
  const auto ask = [&](const DifferentiationVariable& wanted) {
    return differentiate_state(door, zero, zero, zero, {wanted});
  };
  CHECK_THROWS_AS(ask(StateVariable{StateVariable::Kind::q, 2}), std::invalid_argument);
  CHECK_THROWS_AS(ask(MechanismVariable{.kind = Kind::body_mass, .index = 9}), std::invalid_argument);
  CHECK_THROWS_AS(ask(MechanismVariable{.kind = Kind::body_com, .index = 1, .row = 3}), std::invalid_argument);
  CHECK_THROWS_AS(ask(MechanismVariable{.kind = Kind::spring_stiffness, .index = 0}), std::invalid_argument);
}
