/// What a batch costs above its simulations: 1,000 cases on two threads, against the same cases read, simulated and written by
/// a bare loop on two threads.

#include "balance/interface/batch/batch_run.hpp"
#include "balance/interface/batch/batch_summary.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <benchmark/benchmark.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

namespace balance::bench {

namespace {

namespace fs = std::filesystem;

constexpr long cases = 1000;
constexpr int threads = 2;

batch::BatchPlan plan() {
  const std::string suite = "matrix: {spec: 3rrr.yaml, trajectory: cycloid, set: {xg: {from: -0.09, to: 0.09, count: " +
                            std::to_string(cases) + "}}}\n";
  return make_batch_plan(batch::parse_suite(suite, std::string(BALANCE_CONFIGS) + "/bench.yaml"));
}

/// A new folder for every repetition, removed afterwards.
struct Folder {
  Folder() : path((fs::temp_directory_path() / "balance-batch-bench").string()) { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  std::string path;
};

void run_bare(const batch::BatchPlan& plan, const std::string& folder, files::Durability durability) {
  fs::create_directories(folder);
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < plan.cases.size(); i = next++) {
      const batch::SuiteCase& one = plan.suite.cases[i];
      const batch::SpecSource& spec = plan.specs[plan.cases[i].spec];
      const Study study = read_spec(spec.text, spec.path, {.set = one.overrides});
      const RunResult result = simulate(study.mechanism, study.trajectories.front());
      const files::Provenance description = files::make_simulation_provenance(
          study, study.trajectories.front(), {.spec_file = spec.path, .trajectory = "cycloid"});
      write_result_hdf5(folder + "/" + one.name + ".h5", result, description, {.durability = durability});
    }
  };
  std::jthread other(work);
  work();
}

void bare(benchmark::State& state) {
  const batch::BatchPlan all = plan();
  for ([[maybe_unused]] auto _ : state) {
    const Folder folder;
    run_bare(all, folder.path, state.range(0) == 1 ? files::Durability::synced : files::Durability::deferred);
  }
}
BENCHMARK(bare)
    ->Arg(0)
    ->Arg(1)
    ->ArgName("fsync")
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

/// Everything that `balance batch` does: the suite is read, too, and the summaries are written.
void batch(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) {
    const Folder folder;
    const batch::BatchPlan all = plan();
    batch::BatchOptions options;
    options.folder = folder.path;
    options.jobs = threads;
    batch::BatchOutcome outcome = run_batch(all, options);
    write_summary(folder.path, summarise_batch(all.suite, std::move(outcome.records)));
  }
}
BENCHMARK(batch)->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace

}  // namespace balance::bench
