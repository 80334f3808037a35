/// Time of a figure with its derivatives by eight numbers of the motion, as a ratio to the plain run.

#include "balance/analysis/figure_gradient.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/spec/read_spec.hpp"

#include <benchmark/benchmark.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <string>

namespace balance::bench {

namespace {

/// The guided 3RRR, the angle of its platform by a spline of eight coefficients.
DesignSpace open_angle() {
  std::ifstream file(BALANCE_CONFIGS "/3rrr.yaml");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text = text.substr(0, text.find("\ntrajectories:")) +
         "\ntrajectories:\n  calm: {law: bang-bang, drive: com, remaining: {angle: {spline: {free: [-1, 1], knots: "
         "8}}}}\n";
  return read_design_space(text, "3rrr.yaml");
}

template <class Work>
double seconds(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void slopes(benchmark::State& bench) {
  const DesignSpace space = open_angle();
  const VectorX x = VectorX::Constant(8, 0.1);
  const Trial trial = space.trial(x);
  double plain = 0, derived = 0;
  for (auto _ : bench) {
    plain += seconds([&] { benchmark::DoNotOptimize(simulate(trial.mechanism, trial.trajectories.front()).energy); });
    derived +=
        seconds([&] { benchmark::DoNotOptimize(figure_slopes(space, x, "calm", {"shaking_moment"}).energy.value); });
  }
  bench.counters["ratio"] = derived / plain;
}
BENCHMARK(slopes)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace balance::bench
