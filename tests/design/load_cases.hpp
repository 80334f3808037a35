#pragma once
/// Specs for several loads, and what is asked of their designs.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/design/case_objective.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

namespace load_cases {

using balance::DesignReport;
using balance::DesignSpace;
using balance::DesignStatus;
using balance::VectorX;
using balance::design::AdaptiveLaw;
using balance::design::LoadCaseReport;

inline constexpr double g = 9.81;

inline DesignReport find_design(const DesignSpace& space) {
  balance::DesignStudyOptions options;
  options.search = space.start.design.search;
  options.compare_trajectories = false;
  return run_design_study(space, options);
}

inline DesignSpace read(const std::string& text) { return balance::read_design_space(text, "s.yaml"); }

inline std::string file_text(const std::string& name) {
  std::ifstream file(std::string(BALANCE_CONFIGS) + "/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// Coefficient of a law; 0 where there is no such term.
inline double coefficient(const AdaptiveLaw& law, Eigen::Index which, const std::vector<int>& powers) {
  for (const AdaptiveLaw::Term& term : law.terms)
    if (term.powers == powers) return term.coefficients[which];
  return 0;
}

/// Largest scaled residual of the goals' conditions with all numbers as the law says.
inline double left_over(const DesignSpace& space, const DesignReport& report, const VectorX& loads) {
  VectorX x = report.outcome.x;
  x(report.adaptive->numbers) = report.adaptive->law->evaluate(loads);
  const balance::Mechanism mechanism = balance::design::at_load(space, loads).study_at(x).mechanism;
  const balance::Conditions conditions = balance::derive_conditions(mechanism, space.start.design.goals);
  REQUIRE(conditions.rank > 0);
  return scaled_residuals(conditions, balance::conditions::term_values(mechanism)).cwiseAbs().maxCoeff();
}

/// The law put back for loads in its range: round-off of sums of masses times lengths.
inline void check_random_loads(const DesignSpace& space, const DesignReport& report, int count = 50) {
  const balance::MatrixX& values = space.start.design.cases.values;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  for (int k = 0; k < count; ++k) {
    VectorX loads(values.cols());
    for (Eigen::Index i = 0; i < loads.size(); ++i)
      loads[i] = values.col(i).minCoeff() + part(random) * (values.col(i).maxCoeff() - values.col(i).minCoeff());
    CHECK(left_over(space, report, loads) < 1e-12);
  }
}

inline constexpr const char* rr = R"(
name: RR arm
space: planar
gravity: [0, -9.81]
parameters: {a1: 0.5, a2: 0.4, mp: 0.5}
ground:
  points: {O: [0, 0]}
bodies:
  link1: {mass: 2, com: ["a1 / 2", 0], inertia: 0.042, points: {P1: [0, 0], P2: [a1, 0]}}
  link2: {mass: 1.5, com: ["a2 / 2", 0], inertia: 0.02, points: {P2: [0, 0], P3: [a2, 0]}}
payloads:
  cargo: {body: link2, at: [0.4, 0], mass: mp}
counterweights:
  cw1: {body: link1, at: [{free: [-1, -0.05]}, 0], mass: 12}
  cw2: {body: link2, at: [{free: [-1, -0.05]}, 0], mass: 4}
joints:
  R1: {type: revolute, connects: [ground.O, link1.P1]}
  R2: {type: revolute, connects: [link1.P2, link2.P2]}
actuators: [R1, R2]
tool: link2.P3
motion: {duration: 1, samples: 11, from: {joints: {R1: 0, R2: 0}}, to: {joints: {R1: 1, R2: 1}}}
design: {goal: static, for: {mp: [0, 0.5, 1]}, adapt: [cw1.at, cw2.at]}
)";

/// A link of first moment 0.5 kg m with a load at 0.5 m and a counterweight at −0.5 m, which ought to be 1 kg + the load.
inline constexpr const char* pendulum = R"(
space: planar
gravity: [0, -9.81]
parameters: {p: 0}
bodies:
  link: {mass: 2, com: [0.25, 0], inertia: 0.02, points: {E: [0.5, 0]}}
payloads: {cargo: {body: link, at: E, mass: p}}
counterweights: {cw: {body: link, at: [-0.5, 0], mass: {free: [0, 5]}}}
joints: {J: {type: revolute, connects: [ground.origin, link.origin]}}
actuators: [J]
motion: {duration: 1000, samples: 101, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
design: {goal: static, for: {p: [0, 0.25, 1]}}
)";

inline double resting(const LoadCaseReport& one, std::size_t which) {
  for (const balance::conditions::PeakEffort& effort : one.static_efforts)
    if (effort.actuator == static_cast<int>(which)) return effort.magnitude;
  return 0;
}

}  // namespace load_cases
