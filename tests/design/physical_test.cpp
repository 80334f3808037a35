#include "mechanisms.hpp"
#include "objectives.hpp"

#include <doctest/doctest.h>
#include <Eigen/Eigenvalues>

#include <limits>
#include <random>

using namespace design_tests;

namespace {

/// Bodies have mass and inertia that bodies can have.
bool physical(const Mechanism& m) {
  for (std::size_t b = 1; b < m.bodies.size(); ++b) {
    const Body& body = m.bodies[b];
    if (!(body.mass > 0)) return false;
    if (m.space == SpaceKind::planar) {
      if (!(body.inertia(2, 2) > 0)) return false;
      continue;
    }
    const Vector3 principal = Eigen::SelfAdjointEigenSolver<Matrix3>(body.inertia).eigenvalues();
    if (!(principal[0] > 0 && principal[0] + principal[1] >= principal[2])) return false;
  }
  for (const Attachment& a : m.attachments)
    if (a.mass < 0 || a.inertia(2, 2) < 0) return false;
  return true;
}

/// A link turning about x, whose moments of inertia are free.
DesignProblem spatial_link() {
  return problem(
      {{"Ixx", 0, 1, 0.3}, {"Iyy", 0.2, 0.2, 0.2}, {"Izz", 0.1, 0.5, 0.3}},
      [](const VectorX& x) {
        Mechanism m;
        m.space = SpaceKind::spatial;
        m.gravity = {0, 0, -9.81};
        m.bodies = {{"ground", 0, Vector3::Zero(), Matrix3::Zero(), {at("O", 0, 0)}},
                    {"link", 1, Vector3::Zero(), x.asDiagonal(), {at("A", 0, 0), at("B", 0.3, 0)}}};
        m.joints = {revolute("J", 0, 1, Vector3::Zero())};
        m.joints[0].axis = Vector3::UnitX();
        m.coordinates = list_coordinates(m.space, m.joints);
        m.actuators = {0};
        return m;
      },
      GoalKind::statics);
}

}  // namespace

TEST_CASE("no moment of inertia falls below the difference of the other two") {
  // Ixx alone is to be small while Izz is to be 0.5: Ixx >= Izz - Iyy = 0.3
  auto design = spatial_link();
  Objective objective;
  objective.is_convex = true;
  objective.function = of_parameters([](const VectorX& p, VectorX* gradient) {
    if (gradient != nullptr) *gradient = VectorX::Unit(p.size(), 4) - 10 * VectorX::Unit(p.size(), 6);
    return p[4] - 10 * p[6] + 10;  // m, mx, my, mz, Ixx, Iyy, Izz
  });
  design.objective = objective;
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::balanced);
  CHECK(physical(design.model->build_mechanism(outcome.x)));
  CHECK(outcome.x[2] == doctest::Approx(0.5).epsilon(1e-5));
  // bodies keep a millionth of their inertia above the limit
  CHECK(outcome.x[0] == doctest::Approx(0.3).epsilon(1e-4));
  CHECK(outcome.optimality == Optimality::proved_global);
}

TEST_CASE("every design is physical, within its bounds, and judged balanced only if it is") {
  std::mt19937 random(9);
  const auto pick = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  int balanced = 0;
  for (int trial = 0; trial < 30; ++trial) {
    CAPTURE(trial);
    const double l1 = pick(0.3, 0.7), l2 = pick(0.3, 0.7), m1 = pick(0.5, 4), m2 = pick(0.5, 2), j1 = pick(0.05, 0.5);
    const double reach = pick(0.1, 0.6);
    // masses from zero, an inertia about the origin: its part about the CoM shrinks as the CoM moves away
    auto design = problem(
        {{"m1", 0, 6, m1},
         {"com1", -reach, reach, 0.05},
         {"m2", 0, 3, m2},
         {"com2", -reach, reach, 0.1},
         {"cw.mass", 0, 4, 0},
         {"cw.at", -reach, 0, -0.1}},
        [=](const VectorX& x) {
          Mechanism m = planar_arm({l1, l2}, {x[0], x[2]});
          m.bodies[1].com[0] = x[1];
          m.bodies[1].inertia = about_z(j1 - x[0] * x[1] * x[1]);
          m.bodies[2].com[0] = x[3];
          m.bodies[2].inertia = about_z(0.01);
          m.attachments = {counterweight("cw", 1, x[5], 0, x[4])};
          return m;
        },
        GoalKind::statics);
    if (trial % 3 == 1)
      design.objective =
          sum_of(design.model->build_mechanism(VectorX::Zero(6)), dynamics::ParameterOwner::attachment, "m");
    if (trial % 3 == 2)
      design.objective =
          sum_of(design.model->build_mechanism(VectorX::Zero(6)), dynamics::ParameterOwner::body, "m", true);
    if (!physical(design.model->build_mechanism(VectorX{{m1, 0.05, m2, 0.1, 0, -0.1}}))) continue;
    const DesignOutcome outcome = solve_design(design);
    CHECK(within_bounds(design, outcome.x));
    CHECK(physical(design.model->build_mechanism(outcome.x)));
    // Numbers are searched in fractions of their ranges: what is left of a mass that nearly vanishes has that resolution.
    const double resolution = std::numeric_limits<double>::epsilon() * 6 / std::min(outcome.x[0], outcome.x[2]);
    CHECK((outcome.status == DesignStatus::balanced) ==
          (judged(design, outcome.x) < condition_tolerance + 4 * resolution));
    balanced += outcome.status == DesignStatus::balanced;
  }
  CHECK(balanced > 10);
}
