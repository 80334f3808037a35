/// Laws of motion that are found for a mechanism, with the run of 1,001 samples behind the search.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include <benchmark/benchmark.h>

#include <stdexcept>
#include <string>

namespace balance {
namespace {

/// Six turning joints with the proportions of a UR5.
constexpr const char* six_axes = R"(
name: six-axis arm
space: spatial
gravity: [0, 0, -9.81]
ground: {points: {O: [0, 0, 0]}}
bodies:
  b1: {mass: 3.7, com: [0, -0.02, 0.06], inertia: [0.0103, 0.0103, 0.0067], points: {A: [0, 0, 0], B: [0, 0, 0.089]}}
  b2: {mass: 8.4, com: [0.21, 0, 0.11], inertia: [0.0227, 0.2270, 0.2270], points: {B: [0, 0, 0], C: [0.425, 0, 0]}}
  b3: {mass: 2.3, com: [0.15, 0, 0.02], inertia: [0.0031, 0.0494, 0.0494], points: {C: [0, 0, 0], D: [0.392, 0, 0]}}
  b4: {mass: 1.2, com: [0, 0.01, 0.05], inertia: [0.0025, 0.0025, 0.0022], points: {D: [0, 0, 0], E: [0, 0.109, 0]}}
  b5: {mass: 1.2, com: [0, 0.01, 0.04], inertia: [0.0025, 0.0025, 0.0022], points: {E: [0, 0, 0], F: [0, 0, 0.095]}}
  b6: {mass: 0.5, com: [0, 0.02, 0.03], inertia: [0.0008, 0.0008, 0.0009], points: {F: [0, 0, 0], T: [0, 0.082, 0]}}
joints:
  J1: {type: revolute, connects: [ground.O, b1.A], axis: [0, 0, 1]}
  J2: {type: revolute, connects: [b1.B, b2.B], axis: [0, 1, 0]}
  J3: {type: revolute, connects: [b2.C, b3.C], axis: [0, 1, 0]}
  J4: {type: revolute, connects: [b3.D, b4.D], axis: [0, 1, 0]}
  J5: {type: revolute, connects: [b4.E, b5.E], axis: [0, 0, 1]}
  J6: {type: revolute, connects: [b5.F, b6.F], axis: [0, 1, 0]}
actuators: [J1, J2, J3, J4, J5, J6]
tool: b6.T
motion:
  samples: 1001
  from: {joints: {J1: 0, J2: -1, J3: 1.2, J4: -0.4, J5: 0.3, J6: 0}}
  to: {joints: {J1: 1.4, J2: -0.6, J3: 0.7, J4: 0.5, J5: 1.1, J6: 0.9}}
trajectories:
  fast: {law: fastest, drive: joints, limits: {"torque[J1]": 150, "torque[J2]": 150, "torque[J3]": 150, "torque[J4]": 28, "torque[J5]": 28, "torque[J6]": 28}}
)";

Trajectory of_force(const Study& study) {
  Trajectory trajectory = study.trajectories.front();
  trajectory.law.kind = MotionLawKind::time_optimal;
  trajectory.limits = {{"shaking_force", 549.2528818391}};
  trajectory.samples = 1001;
  return trajectory;
}

void search(benchmark::State& timer, const Mechanism& mechanism, const Trajectory& trajectory) {
  for (auto _ : timer)
    if (time_optimal::resolve_trajectory(mechanism, trajectory).outcome.status != MotionStatus::done)
      throw std::runtime_error("no law");
}

void run(benchmark::State& timer, const Mechanism& mechanism, const Trajectory& trajectory) {
  for (auto _ : timer) benchmark::DoNotOptimize(simulate(mechanism, trajectory).torque.data());
}

Study planar() { return read_spec_file(std::string(BALANCE_CONFIGS) + "/3rrr.yaml"); }
Study spatial() { return read_spec(six_axes, "six-axes.yaml"); }

void fastest_3rrr(benchmark::State& timer) {
  const Study study = planar();
  search(timer, study.mechanism, of_force(study));
}
void fastest_3rrr_run(benchmark::State& timer) {
  const Study study = planar();
  run(timer, study.mechanism, of_force(study));
}
void fastest_six_axes(benchmark::State& timer) {
  const Study study = spatial();
  search(timer, study.mechanism, study.trajectories.front());
}
void fastest_six_axes_run(benchmark::State& timer) {
  const Study study = spatial();
  run(timer, study.mechanism, study.trajectories.front());
}

BENCHMARK(fastest_3rrr)->Unit(benchmark::kMillisecond);
BENCHMARK(fastest_3rrr_run)->Unit(benchmark::kMillisecond);
BENCHMARK(fastest_six_axes)->Unit(benchmark::kMillisecond);
BENCHMARK(fastest_six_axes_run)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace balance
