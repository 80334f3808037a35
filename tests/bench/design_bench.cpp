/// Time to derive the balancing conditions of the 3RRR, and to design to them.

#include "fixtures.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <benchmark/benchmark.h>

#include <string>

namespace balance::bench {

namespace {

const Goal force{GoalKind::force};

void conditions(benchmark::State& bench, const Goal& goal) {
  const Mechanism mechanism = three_rrr();
  for (auto _ : bench) {
    const Conditions found = derive_conditions(mechanism, {goal});
    if (found.status != ConditionsStatus::done) return bench.SkipWithError(found.reason.c_str());
    benchmark::DoNotOptimize(found.matrix.data());
  }
}
BENCHMARK_CAPTURE(conditions, force, force)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(conditions, dynamic, {GoalKind::dynamic})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(conditions, gyroscopic, {GoalKind::gyroscopic})->Unit(benchmark::kMillisecond);

/// A mechanism whose attachments' masses are free.
class CounterweightModel final : public design::DesignModel {
 public:
  explicit CounterweightModel(Mechanism mechanism) : mechanism_(std::move(mechanism)) {}
  Mechanism build_mechanism(const VectorX& x) const override {
    Mechanism at = mechanism_;
    for (std::size_t k = 0; k < at.attachments.size(); ++k) at.attachments[k].mass = x[static_cast<Eigen::Index>(k)];
    return at;
  }

 private:
  Mechanism mechanism_;
};

/// The 3RRR with a counterweight of free mass 0.1 m behind the first joint of every crank and coupler: 2.7 kg on couplers, 9.36 kg
/// on cranks make its shaking force vanish (configs/3rrr-force-balance.yaml derives them by hand).
design::DesignProblem counterweights() {
  Mechanism mechanism = three_rrr();
  design::DesignProblem problem;
  for (int body = 1; body <= 6; ++body) {
    Attachment weight;
    weight.name = "cw" + std::to_string(body);
    weight.body = body;
    weight.position = {-0.1, 0, 0};
    mechanism.attachments.push_back(weight);
    problem.variables.push_back({"counterweights." + weight.name + ".mass", 0, 20, 1});
  }
  problem.model = std::make_shared<const CounterweightModel>(mechanism);
  problem.goals = {force};
  return problem;
}

void exact_design(benchmark::State& bench) {
  const design::DesignProblem problem = counterweights();
  for (auto _ : bench) {
    const design::DesignOutcome outcome = solve_design(problem);
    if (outcome.status != DesignStatus::balanced) return bench.SkipWithError(outcome.reason.c_str());
    benchmark::DoNotOptimize(outcome.x.data());
  }
}
BENCHMARK(exact_design)->Unit(benchmark::kMillisecond);

/// The same from the spec: every mechanism that the search tries is read from YAML again. Trajectories are left out.
void design_of_spec(benchmark::State& bench) {
  const DesignSpace space = read_design_space_file(BALANCE_CONFIGS "/3rrr-force-balance.yaml");
  DesignStudyOptions options;
  options.search = space.start.design.search;
  options.compare_trajectories = false;
  for (auto _ : bench) {
    const DesignReport report = run_design_study(space, options);
    if (report.outcome.status != DesignStatus::balanced) return bench.SkipWithError(report.outcome.reason.c_str());
    benchmark::DoNotOptimize(report.outcome.x.data());
  }
}
BENCHMARK(design_of_spec)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace balance::bench
