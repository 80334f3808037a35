// Gains that nobody stated.

#include "../sampling.hpp"
#include "plant_cases.hpp"

#include "balance/motion/control/closed_loop_run.hpp"

#include <cmath>

using namespace plants;

namespace {

const char* const leg = R"(
name: Pantograph leg driven by a Chebyshev lambda linkage
space: planar
units: {length: mm, mass: g, angle: deg, force: N}
gravity: [0, -9810]
parameters: {u: 25, a: 110}
ground:
  points: {O: [0, 0], C: [2*u, 0], P: [2*u, 50]}
bodies:
  crank:   {mass: 40, com: [u/2, 0], inertia: 4000, points: {O: [0, 0], A: [u, 0]}}
  coupler: {mass: 120, com: [2.5*u, 0], inertia: 160000, points: {A: [0, 0], B: [2.5*u, 0], D: [5*u, 0]}}
  rocker:  {mass: 60, com: [1.25*u, 0], inertia: 20000, points: {C: [0, 0], B: [2.5*u, 0]}}
  thigh:   {mass: 150, com: [a, 0], inertia: 600000, points: {P: [0, 0], E: [a, 0], G: [2*a, 0]}}
  shank:   {mass: 150, com: [a, 0], inertia: 600000, points: {G: [0, 0], H: [a, 0], F: [2*a, 0]}}
  short1:  {mass: 70, com: [a/2, 0], inertia: 70000, points: {E: [0, 0], D: [a, 0]}}
  short2:  {mass: 70, com: [a/2, 0], inertia: 70000, points: {H: [0, 0], D: [a, 0]}}
joints:
  O: {type: revolute, connects: [ground.O, crank.O]}
  A: {type: revolute, connects: [crank.A, coupler.A]}
  B: {type: revolute, connects: [coupler.B, rocker.B]}
  C: {type: revolute, connects: [ground.C, rocker.C]}
  P: {type: revolute, connects: [ground.P, thigh.P]}
  E: {type: revolute, connects: [thigh.E, short1.E]}
  G: {type: revolute, connects: [thigh.G, shank.G]}
  H: {type: revolute, connects: [shank.H, short2.H]}
  D1: {type: revolute, connects: [coupler.D, short1.D]}
  D2: {type: revolute, connects: [coupler.D, short2.D]}
actuators: [O]
tool: shank.F
motion:
  duration: 1
  from: {joints: {O: 0}}
  to: {joints: {O: 360}}
trajectories:
  step: {law: uniform, drive: joints}
controllers:
  wild: {type: pd, kp: 2e6, kd: 3e5}
)";

Controller built_in(const std::string& name) {
  for (Controller controller : study::built_in_controllers())
    if (controller.name == name) return controller;
  FAIL("no controller " << name);
  return {};
}

/// Largest error of the actuated coordinates as a part of their range, at most of one radian or characteristic length.
double worst_error(const Mechanism& mechanism, const RunResult& result) {
  double worst = 0;
  for (const int c : mechanism.actuators) {
    const bool slides = mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length;
    const auto desired = result.desired_position.col(c);
    const double range = desired.maxCoeff() - desired.minCoeff();
    const double unit = slides ? characteristic_length(mechanism) : 1;
    worst = std::max(worst, result.tracking_error.col(c).cwiseAbs().maxCoeff() / std::clamp(range, 0.01 * unit, unit));
  }
  return worst;
}

struct Motion {
  std::string file;
  std::size_t trajectory;
  sampling::Traits traits;
};

/// Every trajectory of the mechanisms with motors.
std::vector<Motion> motions() {
  std::vector<Motion> found;
  for (const std::string& file : specs()) {
    const Study study = config(file);
    if (study.mechanism.actuators.empty()) continue;
    for (std::size_t i = 0; i < study.trajectories.size(); ++i) {
      const Trajectory& t = study.trajectories[i];
      found.push_back({file, i,
                       sampling::traits_of(std::string(BALANCE_CONFIGS "/") + file, static_cast<int>(t.law.kind),
                                           static_cast<int>(t.drive))});
    }
  }
  return found;
}

bool mentions(const RunResult& result, const std::string& words) {
  return std::any_of(result.outcome.notes.begin(), result.outcome.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

}  // namespace

TEST_CASE("default gains lead a leg whose inertia changes much through its whole step (D3)") {
  const Study study = read_spec(leg, "leg.yaml");
  Trajectory step = study.trajectories.at(0);
  step.samples = 201;
  const RunResult wanted = simulate(study.mechanism, step);
  const RunResult result = simulate_closed_loop(study.mechanism, step, built_in("pd"));
  REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
  CHECK(worst_error(study.mechanism, result) < 0.2);
  CHECK(result.torque.cwiseAbs().maxCoeff() < 10 * wanted.torque.cwiseAbs().maxCoeff());
  CHECK_FALSE(mentions(result, "does not track"));
}

TEST_CASE("a controller that loses track is said to (D3)") {
  const Study study = read_spec(leg, "leg.yaml");
  const RunResult result = simulate_closed_loop(study.mechanism, study.trajectories.at(0), study.controllers.at(0));
  CHECK((result.outcome.status != MotionStatus::done || mentions(result, "the controller does not track O")));
}

TEST_CASE("default gains are stable along every trajectory of every config (D3)") {
  for (const Motion& motion :
       sampling::draw("motions under default gains", motions(), 0.1, [](const Motion& m) { return m.traits; })) {
    const Study study = config(motion.file);
    Trajectory trajectory = study.trajectories[motion.trajectory];
    CAPTURE(motion.file);
    CAPTURE(trajectory.name);
    trajectory.samples = 51;
    const RunResult wanted = simulate(study.mechanism, trajectory);
    if (wanted.outcome.status != MotionStatus::done) continue;
    const RunResult result = simulate_closed_loop(study.mechanism, trajectory, built_in("pd"));
    if (result.outcome.status == MotionStatus::mismatch) continue;
    REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
    CHECK(worst_error(study.mechanism, result) < 1);
    CHECK_FALSE(mentions(result, "does not track"));
  }
}
