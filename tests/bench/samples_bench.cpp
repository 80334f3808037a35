/// Cost of one sample: position, velocity, acceleration, torques, shaking force and moment, on one thread.

#include "fixtures.hpp"

#include "balance/mechanics/dynamics/sample_evaluator.hpp"

#include <benchmark/benchmark.h>

namespace balance::bench {

namespace {

/// Walks the whole trajectory; reports time per sample.
void walk(benchmark::State& bench, const Mechanism& mechanism, const Trajectory& trajectory) {
  kinematics::Tree<kinematics::Planar> tree =
      kinematics::compile_tree<kinematics::Planar>(mechanism, prescribed_coordinates(trajectory));
  const kinematics::CompiledTrajectory<kinematics::Planar> plan = compile_trajectory(mechanism, tree, trajectory);
  kinematics::MotionStepper<kinematics::Planar> stepper(mechanism, tree, plan);
  dynamics::SampleEvaluator<kinematics::Planar> observer(mechanism, tree, plan.freedoms, Vector2::Zero());
  const double step = plan.prescribed_motion->duration() / static_cast<double>(trajectory.samples - 1);
  for (auto _ : bench) {
    stepper.begin();
    double sum = 0;
    for (long k = 1; k < trajectory.samples; ++k) {
      if (!stepper.advance(step * static_cast<double>(k))) return bench.SkipWithError(stepper.outcome().reason.c_str());
      observer.evaluate(stepper, dynamics::Detail::forces);
      sum += observer.sample().shaking_moment.z() + observer.sample().effort[0];
    }
    benchmark::DoNotOptimize(sum);
  }
  bench.counters["per_sample"] = benchmark::Counter(static_cast<double>(bench.iterations() * (trajectory.samples - 1)),
                                                    benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void three_rrr_tool(benchmark::State& bench) { walk(bench, three_rrr(), three_rrr_cycloid(1001)); }
BENCHMARK(three_rrr_tool);

void planar_rrr_joints(benchmark::State& bench) { walk(bench, planar_rrr(), planar_rrr_cycloid(1001)); }
BENCHMARK(planar_rrr_joints);

void seven_joint_arm_torques(benchmark::State& bench) {
  const Mechanism arm = seven_joint_arm();
  const kinematics::Tree<kinematics::Spatial> tree = kinematics::compile_tree<kinematics::Spatial>(arm, {});
  kinematics::TreeState<kinematics::Spatial> state(tree.nodes.size());
  std::vector<dynamics::Wrench<kinematics::Spatial>> wrenches(tree.nodes.size());
  double y[7], dy[7], ddy[7], tau[7];
  for (int k = 0; k < 7; ++k) y[k] = 0.3 * k - 1, dy[k] = 1 - 0.2 * k, ddy[k] = 0.5 * k;
  for (auto _ : bench) {
    y[0] += 1e-9;  // a new configuration every time
    dynamics::open_tree_inverse_dynamics<kinematics::Spatial>(tree, y, dy, ddy, arm.gravity, state, wrenches, tau);
    benchmark::DoNotOptimize(tau);
  }
}
BENCHMARK(seven_joint_arm_torques);

}  // namespace

}  // namespace balance::bench
