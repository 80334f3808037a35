/// Conditions with the names of their coefficients: derived once, then again with every length a little larger and smaller. The
/// Delta robot has 130 parameters; walking through configurations anew for every length took it 1.2 to 5 s.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/conditions/perturbed_conditions.hpp"
#include "balance/synthesis/conditions/spec_symbols.hpp"

#include <benchmark/benchmark.h>

#include <string>

namespace balance::bench {

namespace {

void named(benchmark::State& bench, const char* config, GoalKind kind, bool nearby) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config);
  const std::vector<Goal> goals = {{kind}};
  const auto start = simulation::start_coordinates(study);
  const auto prepare = [&](const Mechanism& any) { return simulation::assembled_at(any, start); };
  const std::function<Conditions(const Mechanism&)> derive = [&](const Mechanism& any) {
    return derive_conditions(prepare(any), goals);
  };
  const std::vector<conditions::GeometricSymbol> symbols =
      conditions::list_symbols(read_design_space_file(std::string(BALANCE_CONFIGS) + "/" + config));
  for (auto _ : bench) {
    const Conditions conditions = derive(study.mechanism);
    const auto again =
        nearby ? conditions::make_perturbed_derivation(derive, prepare, study.mechanism, conditions, {}) : derive;
    benchmark::DoNotOptimize(name_coefficients(study.mechanism, conditions, symbols, again));
  }
}

void delta_force(benchmark::State& bench) { named(bench, "delta.yaml", GoalKind::force, true); }
BENCHMARK(delta_force)->Name("Delta, force, named")->Unit(benchmark::kMillisecond);

void delta_static(benchmark::State& bench) { named(bench, "delta-gravity.yaml", GoalKind::statics, true); }
BENCHMARK(delta_static)->Name("Delta, static, named")->Unit(benchmark::kMillisecond);

void delta_anew(benchmark::State& bench) { named(bench, "delta.yaml", GoalKind::force, false); }
BENCHMARK(delta_anew)->Name("Delta, force, named by walking anew")->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace balance::bench
