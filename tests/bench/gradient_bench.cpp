/// Time of a run with its derivatives by eight numbers of the motion, as ratios: a figure's to the plain run's, which works in lanes, and the
/// run's alone to that of the scalar engine.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/spec_figure_gradients.hpp"

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

/// Motion and forces at every stop, sample by sample.
void walk_plainly(const Mechanism& mechanism, const Trajectory& trajectory) {
  const kinematics::CompiledMotion<kinematics::Planar> motion(mechanism, trajectory);
  dynamics::TreeMotionSource<kinematics::Planar> source(mechanism, motion, trajectory.about, dynamics::Detail::forces);
  visit_time_grid(source, trajectory.samples, [&](const trajectory::TimeGridPoint&) { return source.evaluate(); });
}

/// By the spec's free numbers.
derivatives::RunGradient walk_over_duals(const DesignSpace& space, const VectorX& x) {
  std::vector<derivatives::DualNumber> inputs(space.inputs.begin(), space.inputs.end());
  for (int i = 0; i < static_cast<int>(x.size()); ++i)
    inputs[static_cast<std::size_t>(space.free_inputs[static_cast<std::size_t>(i)])] =
        derivatives::DualNumber::variable(x[i], i);
  const study::RecordedValues<derivatives::DualNumber> values(*space.recording, inputs);
  return derivatives::differentiate_run(
      values.mechanism(),
      trajectory::cast_scalar<derivatives::DualNumber>(space.recording->trajectories.front(), values),
      {"shaking_moment"});
}

void slopes(benchmark::State& bench) {
  const DesignSpace space = open_angle();
  const VectorX x = VectorX::Constant(8, 0.1);
  const study::DesignInstance trial = space.instantiate(x);
  double plain = 0, derived = 0, scalar = 0, duals = 0;
  for (auto _ : bench) {
    plain += seconds([&] { benchmark::DoNotOptimize(simulate(trial.mechanism, trial.trajectories.front()).energy); });
    derived += seconds([&] {
      benchmark::DoNotOptimize(design::compute_figure_gradients(space, x, "calm", {"shaking_moment"}).energy.value);
    });
    scalar += seconds([&] { walk_plainly(trial.mechanism, trial.trajectories.front()); });
    duals += seconds([&] { benchmark::DoNotOptimize(walk_over_duals(space, x).run.time); });
  }
  bench.counters["figure"] = derived / plain;
  bench.counters["run"] = duals / scalar;
}
BENCHMARK(slopes)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace balance::bench
