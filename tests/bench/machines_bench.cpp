/// Machines that run: a frame on mounts that a crank shakes, and the orders of an engine.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <benchmark/benchmark.h>

#include <stdexcept>
#include <string>

namespace balance {
namespace {

Study read_machine(const std::string& name) { return read_spec_file(BALANCE_CONFIGS "/machines/" + name + ".yaml"); }

RunResult run_or_throw(const Study& study, const Trajectory& trajectory) {
  RunResult result = simulate(study.mechanism, trajectory);
  if (result.outcome.status != MotionStatus::done) throw std::runtime_error(result.outcome.reason);
  return result;
}

/// Ten seconds from rest, 50 turns of the crank, 2,001 samples.
void shake_frame(benchmark::State& timer) {
  const Study study = read_machine("frame-on-mounts");
  Trajectory start = study::choose_trajectory(study, "start");
  const double turns = 10 / start.duration;
  for (std::size_t k = 0; k < start.to.joints.size(); ++k) start.to.joints[k].value *= turns;  // from zero
  start.duration = 10;
  start.samples = 2001;
  for (auto _ : timer) benchmark::DoNotOptimize(run_or_throw(study, start).torque.data());
}

/// The run and its orders up to the eighth.
void find_orders(benchmark::State& timer) {
  const Study study = read_machine("inline-four");
  for (auto _ : timer) {
    const RunResult run = run_or_throw(study, study.trajectories.front());
    benchmark::DoNotOptimize(results::analyse_orders(run, 8).quantities.data());
  }
}

BENCHMARK(shake_frame)->Name("frame on mounts, 10 s, 2,001 samples")->Unit(benchmark::kMillisecond);
BENCHMARK(find_orders)->Name("inline four, run and orders 1 to 8")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace balance
