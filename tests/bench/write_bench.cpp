/// Cost of writing a result, beside a plain write of as many bytes with the same flush to the disk.

#include "fixtures.hpp"

#include "balance/interface/files/result_file.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <benchmark/benchmark.h>

#include <unistd.h>
#include <cstdio>
#include <filesystem>
#include <vector>

namespace balance::bench {

namespace {

constexpr long samples = 200001;

std::filesystem::path scratch(const char* name) { return std::filesystem::temp_directory_path() / name; }

const RunResult& long_run() {
  static const RunResult result = simulate(three_rrr(), three_rrr_cycloid(samples));
  return result;
}

files::Provenance provenance() {
  files::Provenance description;
  description.title = "3RRR";
  description.version = "bench";
  description.trajectory = "cycloid";
  description.law = "cycloidal";
  description.drive = "tool";
  return description;
}

void write_hdf5(benchmark::State& bench) {
  const std::string path = scratch("balance-bench.h5");
  files::WriteOptions options;
  options.existing = files::OverwritePolicy::replace;
  const RunResult& result = long_run();  // computed before the clock starts
  for (auto _ : bench) write_result_hdf5(path, result, provenance(), options);
  bench.SetBytesProcessed(static_cast<int64_t>(bench.iterations() * std::filesystem::file_size(path)));
  std::filesystem::remove(path);
}
BENCHMARK(write_hdf5)->Unit(benchmark::kMillisecond)->UseRealTime();

void write_plain(benchmark::State& bench) {
  const std::string path = scratch("balance-bench.h5"), plain = scratch("balance-bench.bin");
  write_result_hdf5(path, long_run(), provenance(), {files::OverwritePolicy::replace});
  const std::vector<char> bytes(std::filesystem::file_size(path), 1);
  for (auto _ : bench) {
    std::FILE* file = std::fopen(plain.c_str(), "wb");
    std::fwrite(bytes.data(), 1, bytes.size(), file);
    std::fflush(file);
    fsync(fileno(file));
    std::fclose(file);
  }
  bench.SetBytesProcessed(static_cast<int64_t>(bench.iterations() * bytes.size()));
  std::filesystem::remove(path);
  std::filesystem::remove(plain);
}
BENCHMARK(write_plain)->Unit(benchmark::kMillisecond)->UseRealTime();

void simulate_everything(benchmark::State& bench) {
  const Mechanism mechanism = three_rrr();
  const Trajectory trajectory = three_rrr_cycloid(1001);
  for (auto _ : bench) benchmark::DoNotOptimize(simulate(mechanism, trajectory).energy);
}
BENCHMARK(simulate_everything)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace balance::bench
