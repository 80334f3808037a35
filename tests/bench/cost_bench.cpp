/// Cost of one figure of a trajectory with its gradient, and of getting ready for it. The motion of the 3RRR has 28 parameters.

#include "fixtures.hpp"

#include "balance/synthesis/design/trajectory_cost.hpp"

#include <benchmark/benchmark.h>

namespace balance::bench {

namespace {

/// One evaluation, at ever new parameters.
void evaluate(benchmark::State& bench, Statistic figure, const char* quantity, bool with_gradient) {
  const Mechanism mechanism = three_rrr();
  const design::TrajectoryCost cost(mechanism, three_rrr_cycloid(bench.range(0)));
  const design::CostFunction function = cost.figure(figure, quantity).value();
  VectorX parameters = dynamics::parameter_values(mechanism), gradient;
  for (auto _ : bench) {
    parameters[0] += 1e-9;
    benchmark::DoNotOptimize(function(parameters, with_gradient ? &gradient : nullptr));
  }
}

void rms_objective(benchmark::State& bench) { evaluate(bench, Statistic::rms, "shaking_force", false); }
BENCHMARK(rms_objective)->Name("rms objective, samples:")->Arg(1001)->Arg(100001);

void rms_gradient(benchmark::State& bench) { evaluate(bench, Statistic::rms, "shaking_force", true); }
BENCHMARK(rms_gradient)->Name("rms objective with gradient, samples:")->Arg(1001)->Arg(100001);

void torque_gradient(benchmark::State& bench) { evaluate(bench, Statistic::rms, "torque", true); }
BENCHMARK(torque_gradient)->Name("rms of the worst of three torques with gradient, samples:")->Arg(1001)->Arg(100001);

void peak_gradient(benchmark::State& bench) { evaluate(bench, Statistic::peak, "shaking_force", true); }
BENCHMARK(peak_gradient)->Name("peak objective with gradient, samples:")->Arg(1001)->Unit(benchmark::kMicrosecond);

/// From mechanism and trajectory to the function.
void set_up(benchmark::State& bench) {
  const Mechanism mechanism = three_rrr();
  const Trajectory trajectory = three_rrr_cycloid(bench.range(0));
  for (auto _ : bench)
    benchmark::DoNotOptimize(design::TrajectoryCost(mechanism, trajectory).figure(Statistic::rms, "shaking_force"));
}
BENCHMARK(set_up)->Name("set-up of an rms objective, samples:")->Arg(1001)->Arg(100001)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace balance::bench
