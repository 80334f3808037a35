// A block on a rail, moved by the cycloidal law, with the core of the library alone: no file is read or written.
#include <balance/simulation/simulate.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

int main() {
  constexpr double mass = 3, way = 0.5, duration = 2;
  balance::Mechanism mechanism;
  mechanism.name = "block on a rail";
  mechanism.bodies = {{.name = "ground"}, {.name = "block", .mass = mass}};
  mechanism.joints = {
      {.name = "rail", .type = balance::JointType::prismatic, .second = 1, .axis = balance::Vector3::UnitX()}};
  mechanism.coordinates = balance::list_coordinates(mechanism.space, mechanism.joints);
  mechanism.actuators = {0};
  balance::Trajectory trajectory;
  trajectory.drive = balance::DriveKind::joints;
  trajectory.from.joints = {{.coordinate = 0, .value = 0}};
  trajectory.to.joints = {{.coordinate = 0, .value = way}};
  trajectory.duration = duration;
  const balance::Result result = balance::simulate(mechanism, trajectory);
  const double found = result.torque.cwiseAbs().maxCoeff();
  const double expected = mass * way * 2 * std::numbers::pi / (duration * duration);
  std::printf("%s: peak force %.6f N, by hand %.6f N\n", mechanism.name.c_str(), found, expected);
  return std::abs(found - expected) < 1e-5 * expected ? 0 : 1;
}
