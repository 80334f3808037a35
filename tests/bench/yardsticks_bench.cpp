/// The engine's times as ratios to the yardsticks', of one run on one machine: `yardsticks_bench` prints the table below Google
/// Benchmark's lines. Every time is the least of several repetitions.

#include "fixtures.hpp"
#include "yardsticks.hpp"

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/lanes/lane_kernels.hpp"
#include "balance/motion/simulation/group_stepper.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <map>
#include <random>
#include <string>

namespace balance::bench {

namespace {

constexpr long samples = 1000;
constexpr int repetitions = 9;

void count(benchmark::State& bench, long per_iteration) {
  bench.counters["per_sample"] = benchmark::Counter(static_cast<double>(bench.iterations() * per_iteration),
                                                    benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Random states of an open chain, a row each.
template <int Joints>
struct States {
  std::vector<double> q, dq, ddq, torque;
  States() : q(Joints * samples), dq(q), ddq(q), torque(q) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(-3, 3);
    for (auto* numbers : {&q, &dq, &ddq})
      for (double& number : *numbers) number = any(random);
  }
};

template <int Joints, class Yardstick>
void open_chain_yardstick(benchmark::State& bench, const Yardstick& yardstick) {
  States<Joints> states;
  for (auto _ : bench) {
    for (long k = 0; k < samples * Joints; k += Joints)
      yardstick.torques(&states.q[k], &states.dq[k], &states.ddq[k], &states.torque[k]);
    benchmark::DoNotOptimize(states.torque.data());
  }
  count(bench, samples);
}

template <class S, int Joints>
void open_chain(benchmark::State& bench, const Mechanism& mechanism) {
  const kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, {});
  kinematics::TreeState<S> state(tree.nodes.size());
  std::vector<dynamics::Wrench<S>> wrenches(tree.nodes.size());
  const typename S::Vector gravity = kinematics::to_vector<S>(mechanism.gravity);
  States<Joints> states;
  for (auto _ : bench) {
    for (long k = 0; k < samples * Joints; k += Joints)
      dynamics::open_tree_inverse_dynamics<S>(tree, &states.q[k], &states.dq[k], &states.ddq[k], gravity, state,
                                              wrenches, &states.torque[k]);
    benchmark::DoNotOptimize(states.torque.data());
  }
  count(bench, samples);
}

/// The same in lanes.
template <class S, int Joints>
void open_chain_lanes(benchmark::State& bench, const Mechanism& mechanism, InstructionSet set) {
  const kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, {});
  const typename S::Vector gravity = kinematics::to_vector<S>(mechanism.gravity);
  States<Joints> states;
  const lanes::InverseDynamicsJob job = {samples, states.q.data(), states.dq.data(), states.ddq.data(),
                                         states.torque.data()};
  for (auto _ : bench) {
    if constexpr (kinematics::is_planar<S>)
      lanes::lane_kernels(set).planar_torques(tree, gravity, job);
    else
      lanes::lane_kernels(set).spatial_torques(tree, gravity, job);
    benchmark::DoNotOptimize(states.torque.data());
  }
  count(bench, samples);
}

void three_rrr_yardstick(benchmark::State& bench) {
  const Mechanism mechanism = three_rrr();
  const Trajectory t = three_rrr_cycloid(samples);
  const ThreeRrrYardstick yardstick(mechanism, {1, 1, 1});
  const Plane from = {t.from.tool->x(), t.from.tool->y()}, to = {t.to.tool->x(), t.to.tool->y()};
  for (auto _ : bench)
    for (long k = 0; k < samples; ++k) {
      const ThreeRrrMoment moment = yardstick.at(static_cast<double>(k) / (samples - 1), from, to, t.duration);
      benchmark::DoNotOptimize(&moment);
      benchmark::ClobberMemory();
    }
  count(bench, samples);
}

void three_rrr_forces(benchmark::State& bench) {
  const Mechanism mechanism = three_rrr();
  const Trajectory trajectory = three_rrr_cycloid(samples);
  kinematics::Tree<kinematics::Planar> tree =
      kinematics::compile_tree<kinematics::Planar>(mechanism, prescribed_coordinates(trajectory));
  const kinematics::CompiledTrajectory<kinematics::Planar> plan = compile_trajectory(mechanism, tree, trajectory);
  kinematics::MotionStepper<kinematics::Planar> stepper(mechanism, tree, plan);
  dynamics::SampleEvaluator<kinematics::Planar> observer(mechanism, tree, plan.freedoms, Vector2::Zero());
  const double step = plan.prescribed_motion->duration() / static_cast<double>(samples - 1);
  for (auto _ : bench) {
    stepper.begin();
    for (long k = 1; k < samples; ++k) {
      if (!stepper.advance(step * static_cast<double>(k))) return bench.SkipWithError(stepper.outcome().reason.c_str());
      observer.evaluate(stepper, dynamics::Detail::forces);
      benchmark::DoNotOptimize(observer.sample().shaking_moment);
    }
  }
  count(bench, samples - 1);
}

/// Everything that a file holds, found but not recorded.
void three_rrr_groups(benchmark::State& bench, InstructionSet set) {
  const Mechanism mechanism = three_rrr();
  const Trajectory trajectory = three_rrr_cycloid(samples);
  const kinematics::CompiledMotion<kinematics::Planar> motion(mechanism, trajectory);
  for (auto _ : bench) {
    dynamics::TreeMotionSource<kinematics::Planar> source(mechanism, motion, trajectory.about, dynamics::Detail::all);
    simulation::GroupStepper<kinematics::Planar> leader(source, samples, set);
    if (!visit_time_grid(leader, samples, [&](const trajectory::TimeGridPoint&) { return leader.evaluate(); }))
      return bench.SkipWithError(leader.outcome().reason.c_str());
    benchmark::DoNotOptimize(leader.sample().shaking_moment);
  }
  count(bench, samples);
}

void three_rrr_everything(benchmark::State& bench) {
  const Mechanism mechanism = three_rrr();
  const Trajectory trajectory = three_rrr_cycloid(samples);
  for (auto _ : bench) benchmark::DoNotOptimize(simulate(mechanism, trajectory).outcome.status);
  count(bench, samples);
}

/// Prints as usual and keeps the least time per sample of every benchmark.
class Keeper : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      const double time = run.counters.at("per_sample").value;
      const auto [known, fresh] = least.try_emplace(run.run_name.function_name, time);
      if (!fresh) known->second = std::min(known->second, time);
    }
  }
  std::map<std::string, double> least;
};

struct Ratio {
  const char *what, *measured, *yardstick;
};
constexpr Ratio ratios[] = {
    {"planar RRR, torques at given states", "engine/planar_rrr", "yardstick/planar_rrr"},
    {"seven-joint arm, torques at given states", "engine/seven_joint_arm", "yardstick/seven_joint_arm"},
    {"planar RRR, the same, baseline lanes", "lanes/planar_rrr/baseline", "yardstick/planar_rrr"},
    {"planar RRR, the same, AVX2", "lanes/planar_rrr/avx2", "yardstick/planar_rrr"},
    {"planar RRR, the same, AVX-512", "lanes/planar_rrr/avx512", "yardstick/planar_rrr"},
    {"seven-joint arm, the same, baseline lanes", "lanes/seven_joint_arm/baseline", "yardstick/seven_joint_arm"},
    {"seven-joint arm, the same, AVX2", "lanes/seven_joint_arm/avx2", "yardstick/seven_joint_arm"},
    {"seven-joint arm, the same, AVX-512", "lanes/seven_joint_arm/avx512", "yardstick/seven_joint_arm"},
    {"3RRR, tool on the cycloid, all forces", "engine/three_rrr_forces", "yardstick/three_rrr"},
    {"3RRR, everything found, baseline lanes", "lanes/three_rrr/baseline", "yardstick/three_rrr"},
    {"3RRR, everything found, AVX2", "lanes/three_rrr/avx2", "yardstick/three_rrr"},
    {"3RRR, everything found, AVX-512", "lanes/three_rrr/avx512", "yardstick/three_rrr"},
    {"3RRR, everything that the file holds", "engine/three_rrr_everything", "yardstick/three_rrr"},
};

void print(const std::map<std::string, double>& least) {
  std::printf("\n%-42s %10s %10s %8s\n", "", "us", "yardstick", "ratio");
  for (const Ratio& ratio : ratios) {
    const auto measured = least.find(ratio.measured), yardstick = least.find(ratio.yardstick);
    if (measured == least.end() || yardstick == least.end()) continue;  // not asked for, or failed
    std::printf("%-42s %10.3f %10.3f %8.2f\n", ratio.what, 1e6 * measured->second, 1e6 * yardstick->second,
                measured->second / yardstick->second);
  }
}

template <class Function>
void time(const std::string& name, Function function) {
  benchmark::RegisterBenchmark(name.c_str(), function)->Repetitions(repetitions);
}

}  // namespace

}  // namespace balance::bench

int main(int argc, char** argv) {
  using namespace balance;
  using namespace balance::bench;
  time("yardstick/planar_rrr",
       [](benchmark::State& s) { open_chain_yardstick<3>(s, PlanarRrrYardstick(planar_rrr())); });
  time("engine/planar_rrr", [](benchmark::State& s) { open_chain<kinematics::Planar, 3>(s, planar_rrr()); });
  time("yardstick/seven_joint_arm",
       [](benchmark::State& s) { open_chain_yardstick<7>(s, SevenJointYardstick(seven_joint_arm())); });
  time("engine/seven_joint_arm", [](benchmark::State& s) { open_chain<kinematics::Spatial, 7>(s, seven_joint_arm()); });
  for (const InstructionSet set : list_instruction_sets()) {
    time(std::string("lanes/planar_rrr/") + instruction_set_name(set),
         [set](benchmark::State& s) { open_chain_lanes<kinematics::Planar, 3>(s, planar_rrr(), set); });
    time(std::string("lanes/seven_joint_arm/") + instruction_set_name(set),
         [set](benchmark::State& s) { open_chain_lanes<kinematics::Spatial, 7>(s, seven_joint_arm(), set); });
    time(std::string("lanes/three_rrr/") + instruction_set_name(set),
         [set](benchmark::State& s) { three_rrr_groups(s, set); });
  }
  time("yardstick/three_rrr", three_rrr_yardstick);
  time("engine/three_rrr_forces", three_rrr_forces);
  time("engine/three_rrr_everything", three_rrr_everything);
  // Repetitions in turn: what slows the machine for a while slows all alike.
  std::string in_turn = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments(argv, argv + argc);
  arguments.insert(arguments.begin() + 1, in_turn.data());
  int arguments_count = argc + 1;
  benchmark::Initialize(&arguments_count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(arguments_count, arguments.data())) return 2;
  Keeper keeper;
  benchmark::RunSpecifiedBenchmarks(&keeper);
  print(keeper.least);
}
