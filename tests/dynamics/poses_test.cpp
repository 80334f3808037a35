// Poses that mechanisms can or cannot take, and words about those that they cannot.

#include "configs.hpp"

#include <doctest/doctest.h>

#include <numbers>

using namespace balance;
using namespace balance::kinematics;
using namespace equations;

namespace {

bool says(const MotionOutcome& outcome, const char* words) { return outcome.reason.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("a pose of the tool and the joints that it means are one configuration") {
  const Study study = doors::config("5r.yaml");
  const auto start = start_of(study);
  trajectory::PoseTarget joints;
  for (const int a : study.mechanism.actuators) joints.joints.push_back(start[static_cast<std::size_t>(a)]);
  const ConfigurationResult found = solve_configuration(study.mechanism, joints);
  REQUIRE(found.outcome.status == MotionStatus::done);
  for (std::size_t c = 0; c < start.size(); ++c)
    CHECK(std::abs(std::remainder(found.coordinates[c].value - start[c].value, 2 * std::numbers::pi)) < 1e-10);
}

TEST_CASE("a pose that says too little gets a message with how much") {
  const Study study = doors::config("3rrr.yaml");
  trajectory::PoseTarget pose;
  pose.joints = {start_of(study)[static_cast<std::size_t>(study.mechanism.actuators[0])]};
  const ConfigurationResult found = solve_configuration(study.mechanism, pose);
  CHECK(found.outcome.status == MotionStatus::mismatch);
  CHECK_MESSAGE(says(found.outcome, "states 1 of the 3 numbers"), found.outcome.reason);
}

TEST_CASE("a place that cannot be reached is no pose") {
  const Study study = doors::config("rr.yaml");
  trajectory::PoseTarget pose;
  pose.tool = Vector3(100, 0, 0);
  const ConfigurationResult found = solve_configuration(study.mechanism, pose);
  CHECK(found.outcome.status == MotionStatus::unreachable);
  CHECK(found.coordinates.empty());
}

TEST_CASE("an arm with one motor has an equation of motion but no torques") {
  Mechanism m = doors::config("rr.yaml").mechanism;
  m.actuators.resize(1);
  EquationTerms terms(m);
  const VectorX q = wave(2, 0.1);
  REQUIRE(terms.degrees_of_freedom() == 2);
  const auto own_terms = terms.independent_terms(q);
  REQUIRE(own_terms);
  CHECK(own_terms.value.input.cols() == 1);
  const auto split = terms.split_efforts(q, q, q);
  CHECK(split.outcome.status == MotionStatus::mismatch);
  CHECK_FALSE(split.outcome.reason.empty());
}

TEST_CASE("where the motors do not determine the motion there is no equation, and the words say so") {
  // a parallelogram's crank in line with its base: the coupler may fold
  Mechanism m;
  m.name = "stretched";
  const auto rod = [](const char* name, double length) {
    return Body{
        .name = name, .mass = 1, .com = {length / 2, 0, 0}, .inertia = Vector3(0, 0, 0.1).asDiagonal(), .points = {}};
  };
  m.bodies = {{.name = "ground"}, rod("crank", 0.5), rod("coupler", 1), rod("rocker", 0.8)};
  m.joints = {{.name = "A", .first = 0, .second = 1},
              {.name = "B", .first = 1, .second = 2, .point_first = {0.5, 0, 0}},
              {.name = "D", .first = 0, .second = 3, .point_first = {1, 0, 0}},
              {.name = "C", .first = 2, .second = 3, .point_first = {1, 0, 0}, .point_second = {0.8, 0, 0}}};
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {2};  // the rocker drives: dead where crank and coupler are in line
  m.assembly = {{0, 0.8}, {2, 1.6}};
  EquationTerms terms(m);
  REQUIRE(terms.independent() == std::vector<CoordinateId>{2});
  // crank and coupler stretched: 1.5 from A to C
  const double cosine = (1.5 * 1.5 - 1 - 0.64) / (2 * 0.8);
  const double limit = std::acos(cosine);
  const auto inside = terms.independent_terms(VectorX::Constant(1, limit + 0.3));
  REQUIRE_MESSAGE(inside, inside.outcome.reason);
  const auto dead = terms.independent_terms(VectorX::Constant(1, limit));
  CHECK_FALSE(dead);
  CHECK_FALSE(dead.outcome.reason.empty());
  const auto beyond = terms.independent_terms(VectorX::Constant(1, limit - 0.2));
  CHECK_FALSE(beyond);
  // and the way back is open
  CHECK(terms.independent_terms(VectorX::Constant(1, limit + 0.25)));
}

TEST_CASE("numbers that do not fit are misuse") {
  EquationTerms terms(doors::config("rr.yaml").mechanism);
  CHECK_THROWS_AS(terms.independent_terms(VectorX::Zero(3)), std::invalid_argument);
  CHECK_THROWS_AS(terms.split_efforts(VectorX::Zero(2), VectorX::Zero(1), VectorX::Zero(2)), std::invalid_argument);
  CHECK_THROWS_AS(terms.independent_terms(VectorX::Constant(2, std::nan(""))), std::invalid_argument);
  CHECK_THROWS_AS(EquationTerms(doors::config("rr.yaml").mechanism, {.independent = {"nobody"}}),
                  std::invalid_argument);
}
