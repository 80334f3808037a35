/// Efforts of 100,000 states, which tests/bench/states.py compares with the same question from Python.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <benchmark/benchmark.h>

#include <string>

namespace balance {
namespace {

void efforts(benchmark::State& timer, const std::string& config) {
  const Mechanism mechanism = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config).mechanism;
  const Eigen::Index rows = 100'000;
  const Eigen::Index freedoms = InverseDynamics(mechanism).degrees_of_freedom();
  const VectorX wave = VectorX::LinSpaced(rows, 0, 1000);
  Samples q(rows, freedoms), dq(rows, freedoms), ddq(rows, freedoms);
  for (Eigen::Index k = 0; k < freedoms; ++k) {
    q.col(k) = 0.3 * (wave.array() + static_cast<double>(k)).sin();
    dq.col(k) = 0.3 * (wave.array() + static_cast<double>(k)).cos();
    ddq.col(k) = -q.col(k);
  }
  for (auto _ : timer) {
    InverseDynamics door(mechanism);
    benchmark::DoNotOptimize(door.effort_rows(q, dq, ddq).efforts.data());
  }
}

BENCHMARK_CAPTURE(efforts, spatial_rrr, "spatial-rrr.yaml")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(efforts, scara, "scara.yaml")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace balance
