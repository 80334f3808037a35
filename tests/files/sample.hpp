#pragma once
/// Made-up results whose every value is different, so that no two places can be mistaken for each other.

#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace sample {

using namespace balance;
using namespace balance::files;

inline Samples distinct(Eigen::Index rows, Eigen::Index columns, int quantity) {
  Samples samples(rows, columns);
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index column = 0; column < columns; ++column) {
      samples(row, column) = 1000.0 * quantity + static_cast<double>(row) + 0.1 * static_cast<double>(column);
    }
  }
  return samples;
}

inline void fill_samples(RunResult& r, Eigen::Index rows) {
  const Eigen::Index axes = r.axes, moment_axes = r.moment_axes;
  const auto coordinates = static_cast<Eigen::Index>(r.coordinate_names.size());
  const auto joints = static_cast<Eigen::Index>(r.joint_names.size());
  const auto actuators = static_cast<Eigen::Index>(r.actuator_names.size());
  r.time = VectorX::LinSpaced(rows, 0, 0.1);
  int quantity = 0;
  for (Samples* s : {&r.joint_position, &r.joint_velocity, &r.joint_acceleration})
    *s = distinct(rows, coordinates, ++quantity);
  for (Samples* s : {&r.torque, &r.power}) *s = distinct(rows, actuators, ++quantity);
  for (Samples* s :
       {&r.com_position, &r.com_velocity, &r.com_acceleration, &r.tool_position, &r.shaking_force, &r.ground_force}) {
    *s = distinct(rows, axes, ++quantity);
  }
  for (Samples* s : {&r.shaking_moment, &r.ground_moment}) *s = distinct(rows, moment_axes, ++quantity);
  r.tool_orientation = distinct(rows, r.axes == 2 ? 1 : 4, ++quantity);
  r.joint_force = distinct(rows, joints * axes, ++quantity);
  r.joint_moment = distinct(rows, joints * moment_axes, ++quantity);
  for (Samples* s : {&r.kinetic_energy, &r.potential_energy, &r.mobility}) *s = distinct(rows, 1, ++quantity);
  r.newton_iterations = Eigen::VectorXi::LinSpaced(rows, 3, 3 + static_cast<int>(rows) - 1);
}

/// A mechanism with a revolute, a prismatic and a fixed joint: coordinates and joints differ in number, units are mixed.
inline RunResult result(SpaceKind space, Eigen::Index rows = 5) {
  RunResult r;
  r.outcome.status = MotionStatus::done;
  r.axes = space == SpaceKind::planar ? 2 : 3;
  r.moment_axes = space == SpaceKind::planar ? 1 : 3;
  r.coordinate_names = {"A", "S"};
  r.coordinate_units = {"rad", "m"};
  r.joint_names = {"A", "S", "weld"};
  r.actuator_names = {"A", "S"};
  r.actuator_units = {"N m", "N"};
  r.moment_reference = Vector3(0.5, -0.25, 0);
  fill_samples(r, rows);
  r.metrics = {{"torque[A]", "N m", 103.24281233, 0.03, 50.5, 40.25, 200},
               {"shaking_force", "N", 869.7458, 0.07505, 500, 400, 860}};
  r.energy = 12.5;
  return r;
}

inline Provenance description() {
  return {.title = "Kurbel-Schwinge für Tests",
          .version = "0.1.0",
          .spec_text = "name: made up\n",
          .command_line = "balance simulate a.yaml",
          .trajectory = "cycloid",
          .law = "cycloidal",
          .drive = "tool",
          .formulation = "tree"};
}

/// A folder of its own that goes when the test goes.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "balance-test-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  /// Number of entries, hidden ones too.
  long entries() const { return std::distance(std::filesystem::directory_iterator(path_), {}); }

 private:
  std::filesystem::path path_;
};

inline std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace sample
