// Among designs with equal figures: nothing useless, and one assembly mode.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/design/assembly_continuation.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "load_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

using namespace load_cases;

namespace {

struct FourBar {
  double crank, coupler, rocker, base;
};

FourBar random_crank_rocker(std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1);
  FourBar bars{0.08 + 0.03 * part(random), 0.30 + 0.06 * part(random), 0.22 + 0.05 * part(random),
               0.34 + 0.04 * part(random)};
  return bars;
}

/// @param free_length the coupler's length is free between 90 % and 110 %
std::string four_bar_spec(const FourBar& bars, bool free_length, const std::string& weights,
                          const std::string& design) {
  const std::string coupler =
      free_length ? fmt::format("{{free: [{}, {}], start: {}}}", 0.9 * bars.coupler, 1.1 * bars.coupler, bars.coupler)
                  : fmt::format("{}", bars.coupler);
  return fmt::format(R"(space: planar
gravity: [0, -9.81]
parameters: {{mp: 0.5, a: {}, b: {}, c: {}, d: {}}}
ground: {{points: {{A: [0, 0], D: [d, 0]}}}}
bodies:
  crank: {{mass: 0.4, com: ["a / 2", 0], inertia: 0.001, points: {{O: [0, 0], E: [a, 0]}}}}
  coupler: {{mass: "3 * b", com: ["b / 2", 0.01], inertia: "b^3 / 4", points: {{O: [0, 0], E: [b, 0]}}}}
  rocker: {{mass: 0.7, com: ["c / 2", 0], inertia: 0.004, points: {{O: [0, 0], E: [c, 0]}}}}
joints:
  A: {{type: revolute, connects: [ground.A, crank.O]}}
  B: {{type: revolute, connects: [crank.E, coupler.O]}}
  C: {{type: revolute, connects: [coupler.E, rocker.E]}}
  D: {{type: revolute, connects: [ground.D, rocker.O]}}
payloads: {{cargo: {{body: coupler, at: ["b / 2", 0.05], mass: mp}}}}
counterweights:
{}actuators: [A]
tool: coupler.E
assembly: {{A: 0.5, B: 0.1, D: 1.8}}
motion: {{duration: 0.5, samples: 61, from: {{joints: {{A: 0.5}}}}, to: {{joints: {{A: 6.7831853071795862}}}}}}
trajectories: {{go: {{law: uniform, drive: joints}}}}
design: {}
)",
                     bars.crank, coupler, bars.rocker, bars.base, weights, design);
}

Eigen::Index index_of(const DesignSpace& space, const std::string& path) {
  for (std::size_t i = 0; i < space.start.free_numbers.size(); ++i)
    if (space.start.free_numbers[i].key_path == path) return static_cast<Eigen::Index>(i);
  FAIL("no free number " << path);
  return -1;
}

constexpr const char* useful = "  w: {body: crank, at: [-0.08, 0.01], mass: {free: [0, 6]}}\n";
/// Beside the crank's fixed pivot a mass does not change the shaking force.
constexpr const char* idle = "  idle: {body: crank, at: [0, 0], mass: {free: [0, 6]}}\n";

}  // namespace

TEST_CASE("a mass without effect stays 0, changes nothing, and is what may still change") {
  std::mt19937 random(5);
  const std::vector<std::string> designs = {
      "{minimize: {rms: shaking_force, along: go}}", "{minimize: {peak: shaking_force, along: go}}",
      "{minimize: {rms: shaking_force, along: go}, for: {mp: [0, 1]}}", "{minimize: {mean: shaking_force, along: go}}"};
  for (std::size_t k = 0; k < designs.size(); ++k)
    for (const bool free_length : {false, true}) {
      if (free_length && k > 1) continue;
      CAPTURE(designs[k]);
      CAPTURE(free_length);
      const FourBar bars = random_crank_rocker(random);
      const DesignSpace alone = read(four_bar_spec(bars, free_length, useful, designs[k])),
                        both = read(four_bar_spec(bars, free_length, std::string(useful) + idle, designs[k]));
      const DesignReport without = find_design(alone), with = find_design(both);
      const Eigen::Index number = index_of(both, "counterweights.idle.mass");
      CHECK(with.outcome.x[number] == 0);
      // both are searched to about 1e-6
      CHECK(with.outcome.objective == doctest::Approx(without.outcome.objective).epsilon(1e-5));
      if (k == 3) continue;  // what leaves the mean of a force alone is not looked for in its derivatives
      const std::vector<int>& may_change = with.outcome.solution_set.free_variables;
      CHECK(std::find(may_change.begin(), may_change.end(), static_cast<int>(number)) != may_change.end());
    }
}

TEST_CASE("of two counterweights with the same effect per first moment, the farther one does all the work") {
  std::mt19937 random(11);
  for (const char* figure : {"rms", "peak"}) {
    CAPTURE(figure);
    const std::string design = fmt::format("{{minimize: {{{}: shaking_force, along: go}}}}", figure);
    const FourBar bars = random_crank_rocker(random);
    const DesignSpace space =
        read(four_bar_spec(bars, false,
                           "  near: {body: crank, at: [-0.05, 0], mass: {free: [0, 20], start: 3}}\n"
                           "  far: {body: crank, at: [-0.1, 0], mass: {free: [0, 20], start: 1}}\n",
                           design));
    const DesignReport report = find_design(space);
    CHECK(report.outcome.x[index_of(space, "counterweights.near.mass")] == 0);
    CHECK(report.outcome.x[index_of(space, "counterweights.far.mass")] > 0);
    // the exchange 2 : 1 is still possible, and both take part in it
    CHECK(report.outcome.solution_set.optimal_dimension == 1);
    CHECK(report.outcome.solution_set.free_variables.size() == 2);
  }
}

TEST_CASE("no sampled value of a figure is below its bound, and a start at the bound is proved at once") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0, 1);
  const DesignSpace space = read(four_bar_spec(random_crank_rocker(random), true, useful, R"({minimize: added-mass})"));
  for (const balance::Statistic figure :
       {balance::Statistic::peak, balance::Statistic::rms, balance::Statistic::mean, balance::Statistic::range}) {
    balance::ObjectiveTerm term;
    term.figure = figure;
    term.quantity = "shaking_force";
    term.trajectory = "go";
    const balance::Objective objective = build_objective(space, {term}, space.start_values(), {});
    for (int k = 0; k < 5; ++k) {
      VectorX x = space.start_values();
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        const balance::FreeNumber& number = space.start.free_numbers[static_cast<std::size_t>(i)];
        x[i] = number.lower + part(random) * (number.upper - number.lower);
      }
      CHECK(objective.function->evaluate(x, nullptr) >= objective.lower_bound);
    }
  }
  const DesignReport report = find_design(space);
  CHECK(report.outcome.optimality == balance::Optimality::proved_global);
  CHECK(report.outcome.objective == 0);
  CHECK(report.outcome.lower_bound == 0);
  CHECK(report.outcome.gap() == 0);
  CHECK(report.outcome.effort.geometries == 0);
}

TEST_CASE("the assembly mode of a four-bar is that of its start for all lengths that close") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> part(0, 1);
  for (int trial = 0; trial < 6; ++trial) {
    // a guess that suits neither mode well, so that the nearest one changes with the lengths
    const FourBar bars = random_crank_rocker(random);
    std::string text = four_bar_spec(bars, false, useful, "{minimize: {peak: shaking_force, along: go}}");
    text = replaced(text, "assembly: {A: 0.5, B: 0.1, D: 1.8}",
                    trial % 2 == 0 ? "assembly: {A: 0.5, B: -0.6}" : "assembly: {A: 0.5, B: 0.9, D: 0.2}");
    text = replaced(text, fmt::format("c: {},", bars.rocker),
                    fmt::format("c: {{free: [0.02, 0.9], start: {}}},", bars.rocker));
    text = replaced(text, fmt::format("b: {},", bars.coupler),
                    fmt::format("b: {{free: [0.05, 0.9], start: {}}},", bars.coupler));
    const DesignSpace space = follow_assembly_mode(read(text));
    REQUIRE(space.assembly_mode);
    // sign of the transmission angle: coupler × rocker
    const auto side = [](const balance::Study& study) {
      const std::vector<balance::CoordinateValue> q = start_coordinates(study);
      REQUIRE(q.size() == 4);
      return std::sin(q[0].value + q[1].value - q[3].value);
    };
    const double at_start = side(space.start);
    const double dx = bars.base - bars.crank * std::cos(0.5), dy = bars.crank * std::sin(0.5);
    const double diagonal = std::hypot(dx, dy);
    for (int k = 0; k < 40; ++k) {
      VectorX x = space.start_values();
      const Eigen::Index b = index_of(space, "parameters.b"), c = index_of(space, "parameters.c");
      x[b] = 0.05 + 0.85 * part(random);
      x[c] = 0.02 + 0.88 * part(random);
      const bool closes = std::abs(x[b] - x[c]) < diagonal && x[b] + x[c] > diagonal;
      const balance::DesignInstance instance = space.instantiate(x);
      if (!closes) {
        CHECK_FALSE(instance.mode_issue.empty());
        continue;
      }
      // lengths on both sides of a change point are connected by lengths that close: b + c and |b − c| bound a strip
      REQUIRE(instance.mode_issue.empty());
      CHECK(side(space.study_at(x)) * at_start > 0);
    }
  }
}
