#pragma once
/// Mechanisms of configs/ as plants, and where they start from.

#include "balance/control/plant.hpp"
#include "balance/read/read_spec.hpp"
#include "balance/study/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace plants {

using namespace balance;

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

inline Known known(const Result& result, long row) {
  return {result.joint_position.row(row).transpose(), result.joint_velocity.row(row).transpose(),
          result.joint_acceleration.row(row).transpose(), result.torque.row(row).transpose(), result.time[row]};
}

/// Some moment of a config's first trajectory.
inline Known moment_of(const Study& study, double part) {
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 101;
  const Result result = simulate(study.mechanism, trajectory);
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

}  // namespace plants
