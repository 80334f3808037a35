// Natural coordinates and controlled runs in every size, as the first formulation: every result by its own power.

#include "runs.hpp"
#include "transforms.hpp"

#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace laws;
using namespace balance;

namespace {

constexpr Units corners[] = {{1e-6, 1e-9, 1}, {1e6, 1e9, 1}, {1e-6, 1e9, 1}, {1e6, 1e-9, 1}};

double largest(const Samples& a) { return a.size() == 0 ? 0 : a.cwiseAbs().maxCoeff(); }

/// One run and the same run scaled.
void compare(const Mechanism& m, const RunResult& a, const RunResult& b, const Units& by, double duration,
             double allowed) {
  REQUIRE(a.outcome.status == MotionStatus::done);
  REQUIRE_MESSAGE(b.outcome.status == MotionStatus::done, b.outcome.reason);
  const double L = characteristic_length(m);
  const double force = largest(a.shaking_force) + total_mass(m) * L / (duration * duration);
  const auto off = [](const Samples& one, const Samples& other, double factor, double scale) {
    return one.size() == 0 ? 0 : (one * factor - other).cwiseAbs().maxCoeff() / (factor * scale);
  };
  for (long c = 0; c < a.joint_position.cols(); ++c) {
    const bool slide = m.coordinates[c].kind == CoordinateKind::length;
    CHECK(off(a.joint_position.col(c), b.joint_position.col(c), slide ? by.length : 1, slide ? L : 1) < allowed);
  }
  for (long c = 0; c < a.torque.cols(); ++c) {
    const bool slide = a.actuator_units[c] == "N";
    const double scale = std::max(largest(a.torque), force * (slide ? 1 : L));
    CHECK(off(a.torque.col(c), b.torque.col(c), slide ? by.force() : by.moment(), scale) < allowed);
  }
  CHECK(off(a.shaking_force, b.shaking_force, by.force(), force) < allowed);
  CHECK(off(a.shaking_moment, b.shaking_moment, by.moment(), std::max(force * L, largest(a.shaking_moment))) < allowed);
}

}  // namespace

TEST_CASE("natural coordinates scale over twelve decades of lengths and eighteen of masses") {
  for (const std::string& file : config_names()) {
    const Study study = load(file);
    if (study.mechanism.space != SpaceKind::planar || has_velocity_constraints(study.mechanism)) continue;
    for (Trajectory trajectory : study.trajectories) {
      trajectory.samples = 11;
      const RunResult here = verification::simulate_natural(study.mechanism, trajectory);
      const double mobility = run(file, study.mechanism, trajectory).result.mobility.minCoeff();
      for (const Units& by : corners) {
        INFO(file << ": " << trajectory.name << ", lengths times " << by.length << ", masses times " << by.mass);
        const Experiment there = scaled({study.mechanism, trajectory}, by);
        compare(study.mechanism, here, verification::simulate_natural(there.mechanism, there.trajectory), by,
                trajectory.duration, 1e-9 / std::min(1.0, 10 * mobility));
      }
    }
  }
}

TEST_CASE("controlled runs scale over twelve decades of lengths and eighteen of masses") {
  const std::vector<Controller> all = study::built_in_controllers();
  const auto computed_torque = std::find_if(
      all.begin(), all.end(), [](const Controller& c) { return c.type == study::ControllerType::computed_torque; });
  for (const std::string file : {"3rrr.yaml", "control-5r.yaml", "control-rrr.yaml", "slider-crank.yaml",
                                 "spatial-rrr.yaml", "delta.yaml", "double-pendulum.yaml"}) {
    const Study study = load(file);
    if (study.mechanism.actuators.empty()) continue;
    Trajectory trajectory = study.trajectories.front();
    trajectory.samples = 11;
    trajectory.duration = 0.1;
    const RunResult here = simulate_closed_loop(study.mechanism, trajectory, *computed_torque);
    for (const Units& by : corners) {
      INFO(file << ", lengths times " << by.length << ", masses times " << by.mass);
      const Experiment there = scaled({study.mechanism, trajectory}, by);
      const RunResult other = simulate_closed_loop(there.mechanism, there.trajectory, *computed_torque);
      compare(study.mechanism, here, other, by, trajectory.duration, 1e-7);  // integrated to 1e-9 a step
    }
  }
}
