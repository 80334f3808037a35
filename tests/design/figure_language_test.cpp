// Figures that designs can ask for: what is said of their convexity and slopes holds of the figures themselves.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/objective_builder.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::design;

namespace {

/// A crank with a connecting rod and a slide, a spring, and free masses.
const std::string engine = R"(
space: planar
gravity: [0, -9.81]
parameters: {a: A}
ground: {points: {O: [0, 0], X: [0, 0], S: [-0.3, 0.1], M: [0.2, 0.3]}}
bodies:
  crank: {mass: 2, com: [0.03, 0.01], inertia: 0.01, points: {O: [0, 0], E: [a, 0]}}
  rod: {mass: 1.5, com: [0.1, 0.01], inertia: 0.01, points: {E: [0, 0], P: [0.4, 0], K: [0.1, 0.05]}}
  piston: {mass: 1, com: [0, 0], inertia: 0.01, points: {C: [0, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, crank.O]}
  B: {type: revolute, connects: [crank.E, rod.E]}
  C: {type: revolute, connects: [rod.P, piston.C]}
  X: {type: prismatic, connects: [ground.X, piston.C], axis: [1, 0]}
actuators: [A]
springs: {s: {between: [ground.S, rod.K], stiffness: 40, free_length: 0.1}}
counterweights:
  w: {body: crank, at: [-0.06, 0], mass: {free: [0, 4], start: 1}}
  v: {body: rod, at: [-0.08, 0.02], mass: {free: [0, 4], start: 0.5}}
motion: {duration: 0.4, samples: 61, from: {joints: {A: 0.3}}, to: {joints: {A: "0.3 + 2 * pi"}}}
trajectories: {turn: {law: uniform, drive: joints}}
assembly: {A: 0.3, B: -0.37, C: 0.07, X: 0.49}
design: {minimize: added-mass, subject_to: [LIMIT]}
)";

DesignSpace space_with(const std::string& figure, const std::string& length) {
  std::string text = engine;
  text.replace(text.find("a: A"), 4, "a: " + length);
  text.replace(text.find("LIMIT"), 5, "\"" + figure + " <= 1\"");
  return read_design_space(text, "engine.yaml");
}

const ObjectiveTerm& term_of(const DesignSpace& space) { return space.start.design.subject_to.front().terms.front(); }

const std::vector<std::string> convex_figures = {
    "peak(shaking_force[x], turn)", "rms(joint_force[B][y], turn)",   "maximum(joint_force[X][y], turn)",
    "mean(ground_force[x], turn)",  "range(joint_force[B][x], turn)", "peak(shaking_moment about ground.M, turn)",
    "maximum(torque[A], turn)",     "peak(joint_moment[X], turn)",    "peak(joint_force, turn)"};

}  // namespace

TEST_CASE("convex figures along a motion lie below their chords, and equal those of a run") {
  for (const std::string& figure : convex_figures) {
    CAPTURE(figure);
    const DesignSpace space = space_with(figure, "0.1");
    const Objective objective = build_objective(space, {term_of(space)}, space.start_values(), {});
    CHECK(objective.is_convex);
    REQUIRE(objective.is_of_parameters());
    const auto value = [&](const VectorX& x) {
      return objective.function->evaluate(dynamics::parameter_values(space.instantiate(x).mechanism), nullptr);
    };
    for (int k = 0; k < 6; ++k) {
      const VectorX p = Eigen::Vector2d(0.7 * k, 4 - 0.7 * k), q = Eigen::Vector2d(4 - 0.4 * k, 0.3 * k);
      // round-off of the three values
      CHECK(value((p + q) / 2) <= (value(p) + value(q)) / 2 + 1e-12 * (std::abs(value(p)) + std::abs(value(q))));
      CHECK(value(p) ==
            doctest::Approx(simulation::simulate_figure(space.instantiate(p), term_of(space))).epsilon(1e-10));
    }
  }
}

TEST_CASE("the minimum of a signed quantity is concave; what is not affine claims nothing") {
  const DesignSpace space = space_with("minimum(joint_force[B][y], turn)", "0.1");
  const Objective objective = build_objective(space, {term_of(space)}, space.start_values(), {});
  CHECK(objective.is_concave);
  CHECK_FALSE(objective.is_convex);
  CHECK(std::isinf(objective.lower_bound));  // it may be negative
  for (const char* figure : {"peak(shaking_moment_com, turn)", "rms(com_acceleration[x], turn)",
                             "maximum(distance[w, ground.S], turn)", "minimum(shaking_force, turn)"}) {
    const DesignSpace other = space_with(figure, "{free: [0.08, 0.12], start: 0.1}");
    const Objective unknown = build_objective(other, {term_of(other)}, other.start_values(), {});
    CHECK_FALSE(unknown.is_convex);
    CHECK_FALSE(unknown.is_concave);
  }
}

TEST_CASE("slopes of figures by free numbers are those of differences") {
  for (const char* figure :
       {"rms(shaking_force[x], turn)", "maximum(joint_force[B][y], turn)", "minimum(torque[A], turn)",
        "mean(joint_position[X], turn)", "range(joint_velocity[X], turn)", "rms(com_acceleration[y], turn)",
        "energy(turn)", "peak(joint_force, turn)"}) {
    CAPTURE(figure);
    const DesignSpace space = space_with(figure, "{free: [0.08, 0.12], start: 0.1}");
    const VectorX x = Eigen::Vector3d(0.103, 1.3, 0.7);
    const auto pieces = compute_max_terms(space, {term_of(space)}, {}, x);
    REQUIRE(pieces);
    const VectorX slope = *max_term_gradient(pieces, 3);
    for (Eigen::Index i = 0; i < 3; ++i) {
      // differences miss by h² and by the values' round-off over h
      const double h = i == 0 ? 1e-6 : 1e-5;
      const auto value = [&](double at) {
        VectorX moved = x;
        moved[i] = at;
        return simulation::simulate_figure(space.instantiate(moved), term_of(space));
      };
      const double difference = (value(x[i] + h) - value(x[i] - h)) / (2 * h);
      CHECK(slope[i] == doctest::Approx(difference).epsilon(1e-5).scale(1e-3 * std::abs(value(x[i]))));
    }
  }
}
