// A block on a rail, moved by the cycloidal law and asked about one state, with the core of the library alone: no file is read or
// written. Names of the guest's own stand in nobody's way.
#include <balance/balance.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

struct Planar {};
struct Spatial {};
struct Body {};
struct Joint {};
struct Answer {};
struct InverseDynamics {};
constexpr int closed = 1, ground = 2, Samples = 3, validate = 4;
int cross(int a, int b) { return a * b; }

int main() {
  constexpr double mass = 3, way = 0.5, duration = 2;
  balance::Mechanism mechanism;
  mechanism.name = "block on a rail";
  mechanism.bodies = {{.name = "ground"},
                      {.name = "block", .mass = mass, .inertia = balance::Vector3(0, 0, 0.01).asDiagonal()}};
  mechanism.joints = {
      {.name = "rail", .type = balance::JointType::prismatic, .second = 1, .axis = balance::Vector3::UnitX()}};
  mechanism.coordinates = balance::list_coordinates(mechanism.space, mechanism.joints);
  mechanism.actuators = {0};
  balance::Trajectory trajectory;
  trajectory.drive = balance::DriveKind::joints;
  trajectory.from.joints = {{.coordinate = 0, .value = 0}};
  trajectory.to.joints = {{.coordinate = 0, .value = way}};
  trajectory.duration = duration;
  const balance::RunResult result = balance::simulate(mechanism, trajectory);
  const double found = result.torque.cwiseAbs().maxCoeff();
  const double expected = mass * way * 2 * std::numbers::pi / (duration * duration);
  std::printf("%s: peak force %.6f N, by hand %.6f N\n", mechanism.name.c_str(), found, expected);
  if (!(std::abs(found - expected) < 1e-5 * expected)) return 1;

  balance::InverseDynamics door(mechanism);
  const balance::VectorX one = balance::VectorX::Ones(1);
  const balance::Expected<balance::Sample> state = door.at(one, one, 2 * one);
  std::printf("one state: force %.6f N\n", state.value.effort[0]);
  if (!state || std::abs(state.value.effort[0] - 2 * mass) > 1e-12) return 1;
  mechanism.bodies[1].mass = -1;
  return balance::validate(mechanism).size() == 1 && closed * cross(ground, validate) * Samples == 24 ? 0 : 1;
}
