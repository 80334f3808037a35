/// Cost of one evaluation of the forward dynamics inside an integration: loops closed, rates, accelerations under given
/// efforts, on one thread. To be compared with the cost of one sample of the inverse dynamics (samples_bench).

#include "fixtures.hpp"

#include "balance/motion/control/plant.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <benchmark/benchmark.h>

namespace balance::bench {

namespace {

/// Moves freely from the middle of the trajectory on; reports time per evaluation.
void release(benchmark::State& bench, const Mechanism& mechanism, const Trajectory& trajectory, double duration) {
  const RunResult result = simulate(mechanism, trajectory);
  const long row = trajectory.samples / 2;
  const VectorX q = result.joint_position.row(row).transpose(), dq = result.joint_velocity.row(row).transpose();
  const VectorX efforts = result.torque.row(row).transpose();
  control::Plant plant(mechanism);
  long evaluations = 0;
  for (auto _ : bench) {
    plant.start(0, q, dq);
    const long before = plant.cost().evaluations;
    const MotionOutcome outcome = plant.advance(duration, efforts);
    if (outcome.status != MotionStatus::done) return bench.SkipWithError(outcome.reason.c_str());
    evaluations += plant.cost().evaluations - before;
  }
  bench.counters["per_evaluation"] =
      benchmark::Counter(static_cast<double>(evaluations), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void forward_three_rrr(benchmark::State& bench) { release(bench, three_rrr(), three_rrr_cycloid(101), 0.1); }
BENCHMARK(forward_three_rrr);

void forward_planar_rrr(benchmark::State& bench) { release(bench, planar_rrr(), planar_rrr_cycloid(101), 1); }
BENCHMARK(forward_planar_rrr);

}  // namespace

}  // namespace balance::bench
