// How the door behaves: shapes, names, branches, answers that are none.

#include "every_config.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace {

using namespace balance;
using namespace balance::dynamics;
using namespace balance::trajectory;

VectorX numbers(std::initializer_list<double> values) {
  VectorX v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

/// Two uniform rods in a row in the plane, without weight.
Mechanism two_rods() {
  Mechanism m;
  m.name = "two rods";
  const Matrix3 inertia = Vector3(0, 0, 0.01).asDiagonal();
  m.bodies = {{.name = "ground"},
              {.name = "upper", .mass = 1, .com = {0.2, 0, 0}, .inertia = inertia, .points = {}},
              {.name = "lower", .mass = 1, .com = {0.2, 0, 0}, .inertia = inertia, .points = {}}};
  m.joints = {{.name = "A", .first = 0, .second = 1},
              {.name = "B", .first = 1, .second = 2, .point_first = {0.4, 0, 0}}};
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {0, 1};
  return m;
}

}  // namespace

TEST_CASE("wrong shapes are refused with what was expected and what came") {
  InverseDynamics door(two_rods());
  const VectorX good = VectorX::Zero(2);
  CHECK_THROWS_WITH_AS(door.at(VectorX::Zero(3), good, good), "q: expected 2 numbers for A, B; got 3",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(door.mass_matrix(VectorX::Zero(1)), "q: expected 2 numbers for A, B; got 1",
                       std::invalid_argument);
  const Samples rows = Samples::Zero(1000, 2), wide = Samples::Zero(1000, 3), few = Samples::Zero(999, 2);
  CHECK_THROWS_WITH_AS(door.effort_rows(wide, rows, rows), "q: expected (…, 2) for A, B; got (1000, 3)",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(door.effort_rows(rows, rows, few), "ddq: expected (1000, 2) for A, B; got (999, 2)",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(door.at_rows(rows, rows, rows, VectorX::Zero(3)), "time: expected 1000 numbers or none; got 3",
                       std::invalid_argument);
  const double none = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(door.at(numbers({0, none}), good, good), "q: expected finite numbers", std::invalid_argument);
  VectorX effort;
  CHECK_THROWS_WITH_AS(door.efforts(good, numbers({none, 0}), good, effort), "dq: expected finite numbers",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(door.assemble(good, {{"b", 1}}), "near: there is no coordinate 'b'; nearest is 'B'",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(InverseDynamics(two_rods(), {.independent = {"A"}}),
                       "independent: 1 coordinates (A) for 2 degrees of freedom", std::invalid_argument);
  CHECK_THROWS_WITH_AS(InverseDynamics(two_rods(), {.independent = {"A", "A"}}), "independent: 'A' is named twice",
                       std::invalid_argument);
}

TEST_CASE("arrays say the same as their rows, however they are stored") {
  InverseDynamics door(doors::config("spatial-rrr.yaml").mechanism);
  MatrixX q(20, 3), dq(20, 3), ddq(20, 3);
  for (Eigen::Index k = 0; k < 20; ++k)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double x = static_cast<double>(3 * k + c);
      q(k, c) = std::sin(x), dq(k, c) = std::cos(2 * x), ddq(k, c) = std::sin(3 * x);
    }
  const EffortBatch by_columns = door.effort_rows(q, dq, ddq);
  const EffortBatch by_rows = door.effort_rows(Samples(q), Samples(dq), Samples(ddq));
  const SampleBatch whole = door.at_rows(q, dq, ddq);
  CHECK(by_columns.efforts == by_rows.efforts);
  for (Eigen::Index k = 0; k < 20; ++k) {
    const auto one = door.at(q.row(k).transpose(), dq.row(k).transpose(), ddq.row(k).transpose());
    REQUIRE(one);
    CHECK((one.value.effort.transpose() - by_rows.efforts.row(k)).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((one.value.shaking_force.transpose() - whole.result.shaking_force.row(k)).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("the branch is followed from state to state, and another one is taken when it is asked for") {
  InverseDynamics door(doors::config("four-bar.yaml").mechanism);
  const VectorX still = VectorX::Zero(1);
  const auto start = door.assemble(numbers({1.0}));
  REQUIRE(start);
  // the other mode mirrors coupler and rocker at the diagonal: everything but the crank differs
  std::vector<CoordinateGuess> other;
  for (std::size_t c = 1; c < door.mechanism().coordinates.size(); ++c)
    other.push_back({door.mechanism().coordinates[c].name, -start.value[static_cast<Eigen::Index>(c)]});
  const auto mirrored = door.assemble(numbers({1.0}), other);
  REQUIRE(mirrored);
  CHECK((mirrored.value - start.value).cwiseAbs().maxCoeff() > 0.1);
  // once round in coarse steps and back to where it began, still in that mode
  for (int k = 1; k <= 12; ++k) CHECK(door.at(numbers({1.0 + k * std::numbers::pi / 6}), still, still));
  const Sample again = door.at(numbers({1.0}), still, still).value;
  for (Eigen::Index c = 0; c < again.position.size(); ++c)
    CHECK(std::abs(std::remainder(again.position[c] - mirrored.value[c], 2 * std::numbers::pi)) < 1e-9);
}

TEST_CASE("where the way meets a singularity the answer says so, and the state before stays") {
  // the slider stands still at the ends of its way: between them it determines the crank, beyond them there is nothing
  InverseDynamics door(doors::config("slider-crank.yaml").mechanism, {.independent = {"S"}});
  const VectorX zero = VectorX::Zero(1);
  const auto good = door.at(numbers({0.35}), numbers({1}), zero);
  REQUIRE_MESSAGE(good, good.outcome.reason);
  const auto end = door.at(numbers({0.4}), zero, zero);
  CHECK(end.outcome.status == MotionStatus::drive_singularity);
  CHECK(end.outcome.reason.rfind("on the straight path from the previous state: drive singularity", 0) == 0);
  const auto beyond = door.at(numbers({0.45}), zero, zero);
  CHECK(beyond.outcome.status == MotionStatus::drive_singularity);
  const auto again = door.at(numbers({0.35}), numbers({1}), zero);
  REQUIRE(again);
  CHECK((again.value.position - good.value.position).norm() < 1e-12);
  const auto out = door.assemble(numbers({0.45}));
  CHECK(out.outcome.status == MotionStatus::unreachable);
  CHECK(out.outcome.reason.rfind("the loops cannot be closed with these independent coordinates: ", 0) == 0);
  CHECK(door.at(numbers({0.34}), zero, zero));
}

TEST_CASE("rows without an answer are NaN wherever they stand, and leave the others as they are") {
  const balance::Mechanism five_bar = doors::config("5r.yaml").mechanism;
  const Samples zero = Samples::Zero(4, 2);
  Samples q(4, 2);
  q << 3.1, 0, 2.2, 0.8, 3.1, 0, 2.2, 0.8;  // cranks that point away from each other are too far apart for the arms
  InverseDynamics door(five_bar);
  const SampleBatch found = door.at_rows(q, zero, zero, numbers({1, 2, 3, 4}));
  REQUIRE(found.failures.size() == 2);
  InverseDynamics other(five_bar);
  const SampleBatch reached = other.at_rows(Samples(q.bottomRows(1)), Samples::Zero(1, 2), Samples::Zero(1, 2));
  REQUIRE(reached.failures.empty());
  CHECK(found.result.time == numbers({1, 2, 3, 4}));
  for (const Eigen::Index k : {0, 2}) {
    CHECK(found.failures[static_cast<std::size_t>(k / 2)].row == k);
    for (const balance::Quantity& quantity : list_sampled_quantities(found.result))
      CHECK_MESSAGE((found.result.*quantity.member).row(k).array().isNaN().all(), quantity.name);
    CHECK(found.result.newton_iterations[k] == 0);
    // there Newton's method starts where it ended
    CHECK((found.result.torque.row(k + 1) - reached.result.torque.row(0)).norm() < 1e-9);
  }
}

TEST_CASE("a state beyond reach of the one before is reported at once") {
  InverseDynamics door(doors::config("four-bar.yaml").mechanism);
  const VectorX zero = VectorX::Zero(1);
  REQUIRE(door.assemble(numbers({1.0})));
  const auto far = door.at(numbers({1e9}), zero, zero);
  CHECK(far.outcome.status == MotionStatus::unreachable);
  CHECK(far.outcome.reason == "A is too far from the previous state to be tracked");
  CHECK(door.assemble(numbers({1e9})));
  CHECK(door.at(numbers({1e9}), zero, zero));
}

TEST_CASE("an object can be moved, and each has its own branch") {
  InverseDynamics first(doors::config("5r.yaml").mechanism);
  const VectorX still = VectorX::Zero(2);
  VectorX q(2);
  for (Eigen::Index k = 0; k < 2; ++k) q[k] = 0;
  InverseDynamics second = std::move(first);
  CHECK(second.degrees_of_freedom() == 2);
  std::vector<InverseDynamics> many;
  many.push_back(std::move(second));
  many.emplace_back(two_rods());
  CHECK(many[0].degrees_of_freedom() == 2);
  CHECK(many[1].at(still, still, still));
}

TEST_CASE("without enough actuators everything but the efforts is there") {
  balance::Mechanism m = two_rods();
  m.actuators = {1};
  InverseDynamics door(m);
  CHECK(door.independent() == std::vector<std::string>{"B", "A"});
  REQUIRE(door.notes().size() == 1);
  CHECK(door.notes()[0] == "independent coordinates: B, A");
  const VectorX one = VectorX::Ones(2);
  const auto found = door.at(one, one, one);
  CHECK(found.outcome.status == MotionStatus::mismatch);
  CHECK(std::isnan(found.value.effort[0]));
  CHECK(found.value.shaking_force.norm() > 0);
  CHECK(door.mass_matrix(one));
  CHECK(door.bias(one, one));
  VectorX effort;
  CHECK(door.efforts(one, one, one, effort).status == MotionStatus::mismatch);
  CHECK(std::isnan(door.effort_rows(Samples::Ones(1, 2), Samples::Ones(1, 2), Samples::Ones(1, 2)).efforts(0, 0)));
}

TEST_CASE("a structure has one state, and it is balanced by what its joints transmit") {
  // two rods make a triangle with the ground: no freedom, no actuator
  balance::Mechanism m = two_rods();
  m.gravity = {0, -10, 0};
  m.joints.push_back({.name = "C", .first = 0, .second = 2, .point_first = {0.5, 0, 0}, .point_second = {0.4, 0, 0}});
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators.clear();
  m.assembly = {{0, 0.9}};
  InverseDynamics door(m);
  CHECK(door.degrees_of_freedom() == 0);
  const VectorX nothing;
  const auto found = door.at(nothing, nothing, nothing);
  REQUIRE_MESSAGE(found, found.outcome.reason);
  CHECK(std::abs(found.value.ground_force.y() + 20) < 1e-9);  // the weight of 2 kg
  CHECK(std::abs(found.value.joint_force[0].y() + found.value.joint_force[2].y() - 20) < 1e-9);
}

TEST_CASE("numbers that are too large are said to be so") {
  InverseDynamics door(two_rods());
  const VectorX huge = VectorX::Constant(2, 1e200), zero = VectorX::Zero(2);
  CHECK(door.at(zero, huge, zero).outcome.status == MotionStatus::overflow);
  VectorX effort;
  CHECK(door.efforts(numbers({0, 1}), huge, zero, effort).status == MotionStatus::overflow);
}

TEST_CASE("the efforts do not depend on which coordinates a state is given in") {
  const balance::Mechanism mechanism = doors::config("four-bar.yaml").mechanism;
  InverseDynamics by_crank(mechanism);
  const auto start = by_crank.assemble(numbers({1.2}));
  REQUIRE(start);
  const Sample one = by_crank.at(numbers({1.2}), numbers({2.0}), numbers({-3.0})).value;
  for (std::size_t c = 1; c < mechanism.coordinates.size(); ++c) {
    const auto k = static_cast<Eigen::Index>(c);
    const std::string& name = mechanism.coordinates[c].name;
    CAPTURE(name);
    InverseDynamics other(mechanism, {.independent = {name}});
    std::vector<CoordinateGuess> near;
    for (std::size_t i = 0; i < mechanism.coordinates.size(); ++i)
      near.push_back({mechanism.coordinates[i].name, one.position[static_cast<Eigen::Index>(i)]});
    REQUIRE(other.assemble(numbers({one.position[k]}), near));
    const auto two = other.at(numbers({one.position[k]}), numbers({one.velocity[k]}), numbers({one.acceleration[k]}));
    REQUIRE_MESSAGE(two, two.outcome.reason);
    CHECK((two.value.effort - one.effort).norm() <= 1e-9 * one.effort.norm());
    CHECK((two.value.shaking_force - one.shaking_force).norm() <= 1e-9 * one.shaking_force.norm());
  }
}
