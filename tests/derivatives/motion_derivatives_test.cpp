// Numbers of the motion itself: figures' derivatives are what differences of runs come to, and designs by them end in the known minima.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/design/spec_figure_gradients.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

namespace motion_derivatives_test {

using namespace balance;
using namespace balance::design;

namespace {

/// A config with other trajectories, and perhaps a design.
DesignSpace with_trajectories(const std::string& config, const std::string& trajectories,
                              const std::string& design = "") {
  std::ifstream file(std::string(BALANCE_CONFIGS) + "/" + config);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text = text.substr(0, text.find("\ntrajectories:")) + "\ntrajectories:\n" + trajectories;
  if (!design.empty()) text += "design: {minimize: " + design + "}\n";
  return read_design_space(text, config);
}

const Metric& metric_of(const RunResult& run, const std::string& quantity) {
  for (const Metric& metric : run.metrics)
    if (metric.quantity == quantity) return metric;
  FAIL("no figure of " << quantity);
  return run.metrics.front();
}

/// Differences of fourth order of whole runs, by steps so small that no knot passes a place of the run (there a figure's third derivative
/// jumps): what they leave out and their noise are below 1e-6 of the figure over the range.
template <class Read>
double difference(const DesignSpace& space, const VectorX& x, Eigen::Index number, const Read& read) {
  const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(number)];
  const double h = 2e-4 * (free.upper - free.lower);
  const auto at = [&](double place) {
    VectorX there = x;
    there[number] += place * h;
    const study::DesignInstance trial = space.instantiate(there);
    const RunResult run = simulate(trial.mechanism, trial.trajectories.front());
    REQUIRE(run.outcome.status == MotionStatus::done);
    return read(run);
  };
  return (at(-2) - at(2) + 8 * (at(1) - at(-1))) / (12 * h);
}

void compare(const std::string& config, const std::string& trajectory, const std::string& quantity, int numbers) {
  const DesignSpace space = with_trajectories(config, trajectory);
  REQUIRE(space.start.free_numbers.size() == static_cast<std::size_t>(numbers));
  VectorX x = space.start_values();
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    x[i] += 0.1 * (free.upper - free.lower) / static_cast<double>(i + 2);
  }
  const std::string name = space.start.trajectories.front().name;
  const SpecFigureGradients all = compute_figure_gradients(space, x, name),
                            few = compute_figure_gradients(space, x, name, {quantity, "power"});
  REQUIRE(all.outcome.status == MotionStatus::done);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    INFO(config << " " << trajectory << " by " << space.start.free_numbers[static_cast<std::size_t>(i)].key_path);
    const double range = space.start.free_numbers[static_cast<std::size_t>(i)].upper -
                         space.start.free_numbers[static_cast<std::size_t>(i)].lower;
    const auto check = [&](double found, double size, const auto& read) {
      const double expected = difference(space, x, i, read);
      CHECK(std::abs(found - expected) <= 1e-6 * (std::abs(expected) + size / range));
    };
    const QuantityGradients& figures = *find_quantity(all, quantity);
    check(figures.rms.gradient[i], figures.rms.value,
          [&](const RunResult& run) { return metric_of(run, quantity).rms; });
    check(all.duration.gradient[i], all.duration.value, [](const RunResult& run) { return run.outcome.time; });
    const QuantityGradients& same = *find_quantity(few, quantity);
    CHECK(same.rms.gradient[i] == doctest::Approx(figures.rms.gradient[i]).epsilon(1e-12));
    CHECK(same.peak.gradient[i] == doctest::Approx(figures.peak.gradient[i]).epsilon(1e-12));
    CHECK(few.energy.gradient[i] == doctest::Approx(all.energy.gradient[i]).epsilon(1e-12));
  }
}

/// The objective of a design from several seeds, each as good as the known minimum.
void minimum(const std::string& config, const std::string& trajectory, const std::string& minimize, double known,
             double tolerance, int seeds) {
  for (int seed = 1; seed <= seeds; ++seed) {
    const DesignSpace space = with_trajectories(config, trajectory, minimize);
    DesignStudyOptions options;
    options.search.seed = static_cast<std::uint64_t>(seed);
    options.compare_trajectories = false;
    const DesignReport report = run_design_study(space, options);
    INFO(trajectory << " from seed " << seed);
    CHECK(report.outcome.status == DesignStatus::no_goal);
    CHECK(report.outcome.objective == doctest::Approx(known).epsilon(tolerance));
  }
}

/// @param knots their number; @param more further keys
std::string calm(const std::string& drive, const std::string& knots, const std::string& more = "") {
  return "  calm: {law: bang-bang, drive: " + drive +
         ", samples: 501, remaining: {angle: {spline: {free: [-1, 1], knots: " + knots + "}" + more + "}}}\n";
}

}  // namespace

TEST_CASE("figures change with numbers of the motion as their derivatives say") {
  compare("3rrr.yaml", calm("com", "3"), "shaking_moment", 3);
  compare("3rrr.yaml",
          "  t: {law: cycloidal, drive: tool, samples: 201, duration: {free: [0.08, 0.2]}, to: {tool: [{free: [0.05, "
          "0.1]}, "
          "0.05], angle: {free: [-0.2, 0.2]}}}\n",
          "shaking_moment", 3);
  compare(
      "rr.yaml",
      "  t: {law: 3-4-5, drive: tool, samples: 201, path: {waypoints: [{tool: [{free: [0.2, 0.5]}, {free: "
      "[0.3, 0.6]}]}], blend: spline, times: [{free: [0.2, 0.7]}]}, duration: 1, from: {tool: [0.5, 0.1]}, to: {tool: "
      "[0.1, 0.5]}}\n",
      "torque[R1]", 5);  // and the masses of two counterweights
}

TEST_CASE("splines that leave the least shaking moment are found from any seed: numbers of another program") {
  minimum("3rrr.yaml", calm("com", "3"), "{rms: shaking_moment, along: calm}", 7.615992, 1e-4, 2);
  minimum("3rrr.yaml", calm("com", "5", ", jump: true"), "{rms: shaking_moment, along: calm}", 6.065944, 1e-4, 1);
  minimum("3rrr-redistributed.yaml", calm("tool", "5"), "{rms: shaking_moment, along: calm}", 2.450087, 1e-4, 1);
}

TEST_CASE("the least peak is that of a maximum, with several places at their largest at once") {
  minimum("3rrr-redistributed.yaml", calm("tool", "3"), "{peak: shaking_moment, along: calm}", 5.5467, 1e-4, 1);
}

TEST_CASE("duration and torque against each other: in the plane without weight torques fall with its square") {
  // peak = a / T², so that a / T² + w T is least at T³ = 2 a / w
  const std::string trajectory = "  t: {law: cycloidal, drive: tool, samples: 401, duration: {free: [0.05, 0.5]}}\n";
  const DesignSpace space =
      with_trajectories("3rrr.yaml", trajectory, "[{peak: torque, along: t}, {of: duration, along: t, weight: 2000}]");
  study::DesignInstance trial = space.instantiate(VectorX::Constant(1, 0.1));
  const double a = metric_of(simulate(trial.mechanism, trial.trajectories.front()), "torque").peak * 0.01;
  // and the work done on the motors and by them does, too
  const SpecFigureGradients slopes = compute_figure_gradients(space, VectorX::Constant(1, 0.1), "t");
  CHECK(slopes.energy.gradient[0] == doctest::Approx(-2 * slopes.energy.value / 0.1).epsilon(1e-10));
  DesignStudyOptions options;
  options.compare_trajectories = false;
  const DesignReport report = run_design_study(space, options);
  CHECK(report.outcome.x[0] == doctest::Approx(std::cbrt(2 * a / 2000)).epsilon(1e-5));
}

TEST_CASE("the masses with which the fastest law is quickest: no other masses near them are quicker") {
  const DesignSpace space = with_trajectories("rr.yaml", "  fast: {law: fastest, drive: tool, limits: {torque: 40}}\n",
                                              "{of: duration, along: fast}");
  DesignStudyOptions options;
  options.compare_trajectories = false;
  const DesignReport report = run_design_study(space, options);
  REQUIRE(report.outcome.status == DesignStatus::no_goal);
  const auto min_duration = [&](const VectorX& x) {
    const study::DesignInstance trial = space.instantiate(x);
    const RunResult run = simulate(trial.mechanism, trial.trajectories.front());
    return run.outcome.status == MotionStatus::done ? run.outcome.time : INFINITY;
  };
  const double best = min_duration(report.outcome.x);
  CHECK(best == doctest::Approx(report.outcome.objective).epsilon(1e-12));
  CHECK(best < min_duration(space.start_values()));
  for (Eigen::Index i = 0; i < report.outcome.x.size(); ++i)
    for (const double step : {-0.25, 0.25}) {
      VectorX other = report.outcome.x;
      other[i] = std::clamp(other[i] + step, 0.0, 50.0);
      CHECK(min_duration(other) >= best * (1 - 1e-7));
    }
}

}  // namespace motion_derivatives_test
