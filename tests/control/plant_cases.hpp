#pragma once
/// Mechanisms of configs/ as plants, and where they start from.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/control/plant.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace plants {

using namespace balance;
using namespace balance::control;

inline Study config(const std::string& file) { return read_spec_file(std::string(BALANCE_CONFIGS "/") + file); }

/// Every mechanism of configs/.
inline std::vector<std::string> specs() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);)
      if (line.rfind("bodies:", 0) == 0) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A moment of a motion that the inverse dynamics has solved.
struct Known {
  VectorX q, dq, ddq, efforts;
  double time = 0;
};

inline Known known(const RunResult& result, long row) {
  return {result.joint_position.row(row).transpose(), result.joint_velocity.row(row).transpose(),
          result.joint_acceleration.row(row).transpose(), result.torque.row(row).transpose(), result.time[row]};
}

/// Some moment of a config's first trajectory.
inline Known moment_of(const Study& study, double part) {
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 101;
  const RunResult result = simulate(study.mechanism, trajectory);
  REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
  return known(result, static_cast<long>(100 * part));
}

/// Nothing that takes energy out or puts it in.
inline Mechanism conservative(Mechanism mechanism) {
  mechanism.friction.clear();
  mechanism.loads.clear();
  return mechanism;
}

inline VectorX nothing(const Mechanism& mechanism) {
  return VectorX::Zero(static_cast<Eigen::Index>(mechanism.actuators.size()));
}

inline Mechanism spec(const std::string& text) { return read_spec(text, "spec.yaml").mechanism; }

inline VectorX values(std::initializer_list<double> list) {
  VectorX out(static_cast<Eigen::Index>(list.size()));
  std::copy(list.begin(), list.end(), out.data());
  return out;
}

inline std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

inline PlantOptions tight() {
  PlantOptions options;
  options.relative_tolerance = options.absolute_tolerance = 1e-12;
  return options;
}

inline Plant started(const Mechanism& mechanism, const VectorX& q, const VectorX& dq,
                     const PlantOptions& options = tight()) {
  Plant plant(mechanism, options);
  const MotionOutcome outcome = plant.start(0, q, dq);
  REQUIRE_MESSAGE(outcome.status == MotionStatus::done, outcome.reason);
  return plant;
}

inline void move(Plant& plant, double time, const VectorX& efforts) {
  const MotionOutcome outcome = plant.advance(time, efforts);
  REQUIRE_MESSAGE(outcome.status == MotionStatus::done, outcome.reason);
}

/// Of 2 kg on a rail, tied to the origin by a spring of no length.
inline Mechanism block(double coulomb, double at_rest, double stiffness, double viscous = 0) {
  return spec(R"(
space: planar
bodies: {block: {mass: 2, com: [0, 0], inertia: 0.1, points: {A: [0, 0]}}}
ground: {points: {O: [0, 0]}}
joints: {S: {type: prismatic, connects: [ground.O, block.A], axis: [1, 0]}}
springs: {k: {between: [ground.O, block.A], stiffness: )" +
              exact(stiffness) + R"(, free_length: 0}}
friction: {S: {viscous: )" +
              exact(viscous) + ", coulomb: " + exact(coulomb) + ", static: " + exact(at_rest) + R"(}}
actuators: [S]
)");
}

/// A force along x on the first body that grows from one of these moments to the next in proportion.
inline void push(Mechanism& mechanism, const std::vector<double>& time, const std::vector<double>& force) {
  Load load;
  load.name = "push";
  load.body = 1;
  load.arguments = time;
  for (const double x : force) load.force.emplace_back(x, 0, 0), load.moment.push_back(Vector3::Zero());
  mechanism.loads.push_back(load);
}

}  // namespace plants
