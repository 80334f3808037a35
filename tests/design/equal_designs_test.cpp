// Among designs with equal figures: nothing useless, and one assembly mode.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/design/assembly_continuation.hpp"
#include "balance/synthesis/design/load_case_study.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/pareto_front.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"
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
    const balance::design::Objective objective =
        balance::design::build_objective(space, {term}, space.start_values(), {});
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
  CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
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
    const DesignSpace space = balance::design::follow_assembly_mode(read(text), true);
    REQUIRE(space.assembly_mode);
    // sign of the transmission angle: coupler × rocker
    const auto side = [](const balance::Study& study) {
      const std::vector<balance::CoordinateValue> q = balance::simulation::start_coordinates(study);
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
      const balance::study::DesignInstance instance = space.instantiate(x);
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

namespace {

/// A counterweight whose mass and place along a line through the body's joint are free.
struct MovableWeight {
  Eigen::Index mass, place;
};

/// Figure and largest violation of a limit at x; infinite where they are not defined.
double penalised_figure(const balance::design::DesignProblem& problem, const VectorX& x) {
  const double value = problem.objective->function->evaluate(x, nullptr);
  for (const balance::design::DesignLimit& limit : problem.limits)
    if (!(limit.figure.function->evaluate(x, nullptr) <= limit.bound + 1e-9 * std::abs(limit.bound)))
      return std::numeric_limits<double>::infinity();
  return std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
}

/// Simulated figures as functions of the free numbers.
balance::design::DesignProblem simulated_problem(const DesignSpace& space) {
  balance::design::DesignProblem problem = balance::design::make_design_problem(space, {});
  const auto by_numbers = [&space](balance::design::Objective& figure) {
    struct OfNumbers final : balance::design::DesignFunction {
      std::shared_ptr<const balance::design::DesignFunction> inner;
      const DesignSpace* space = nullptr;
      Domain domain() const override { return Domain::variables; }
      double evaluate(const VectorX& x, VectorX*) const override {
        return inner->domain() == Domain::variables
                   ? inner->evaluate(x, nullptr)
                   : inner->evaluate(balance::dynamics::parameter_values(space->study_at(x).mechanism), nullptr);
      }
    };
    auto function = std::make_shared<OfNumbers>();
    function->inner = figure.function;
    function->space = &space;
    figure.function = function;
  };
  by_numbers(*problem.objective);
  for (balance::design::DesignLimit& limit : problem.limits) by_numbers(limit.figure);
  return problem;
}

/// The laws of a design that has nothing useless.
void check_least_mass(const DesignSpace& space, const DesignReport& report, const std::vector<MovableWeight>& weights) {
  const VectorX& x = report.outcome.x;
  const balance::design::DesignProblem problem = simulated_problem(space);
  const double best = penalised_figure(problem, x);
  REQUIRE(std::isfinite(best));
  // more than what is accepted as equal, and the accuracy of a motion
  const double as_good = best + 1e-9 * std::abs(best);
  for (std::size_t i = 0; i < space.start.free_numbers.size(); ++i) {
    const balance::FreeNumber& number = space.start.free_numbers[i];
    const double range = number.upper - number.lower;
    for (const double special : {0.0, number.lower, number.upper}) {
      const double distance = std::abs(x[static_cast<Eigen::Index>(i)] - special);
      CHECK((distance == 0 || distance > 1e-9 * range));
    }
  }
  for (const MovableWeight& weight : weights) {
    CAPTURE(x[weight.mass]);
    CAPTURE(x[weight.place]);
    if (x[weight.mass] == 0) {
      CHECK(x[weight.place] == space.start.free_numbers[static_cast<std::size_t>(weight.place)].start);
      continue;
    }
    VectorX lighter = x;
    lighter[weight.mass] *= 0.98;
    CHECK(penalised_figure(problem, lighter) > as_good);
    const balance::FreeNumber& place = space.start.free_numbers[static_cast<std::size_t>(weight.place)];
    VectorX farther = x;
    farther[weight.place] = std::clamp(1.02 * x[weight.place], place.lower, place.upper);
    if (std::abs(farther[weight.place]) <= std::abs(x[weight.place]) * (1 + 1e-9)) continue;
    farther[weight.mass] *= x[weight.place] / farther[weight.place];
    CHECK(penalised_figure(problem, farther) > as_good);
  }
}

std::string movable_weights(std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1);
  return fmt::format(
      "  near: {{body: crank, at: [{{free: [-0.12, 0.1], start: {}}}, 0], mass: {{free: [0, 6], start: 0.3}}}}\n"
      "  far: {{body: rocker, at: [{{free: [-0.15, 0.02], start: {}}}, 0], mass: {{free: [0, 6], start: 0.2}}}}\n",
      -0.03 - 0.05 * part(random), -0.04 - 0.05 * part(random));
}

std::vector<MovableWeight> list_movable_weights(const DesignSpace& space) {
  std::vector<MovableWeight> weights;
  for (const char* name : {"near", "far"})
    weights.push_back({index_of(space, fmt::format("counterweights.{}.mass", name)),
                       index_of(space, fmt::format("counterweights.{}.at[0]", name))});
  return weights;
}

}  // namespace

TEST_CASE("no mass of a design can be lowered, alone or with a longer arm, and no number is dust") {
  std::mt19937 random(23);
  for (const char* design :
       {"{minimize: {rms: shaking_force, along: go}}", "{minimize: {peak: shaking_force, along: go}}",
        "{minimize: {peak: \"shaking_force[y]\", along: go}}",
        "{minimize: {mean: shaking_force, along: go}, search: {evaluations: 400}}",
        "{minimize: {peak: \"joint_force[B]\", along: go}, subject_to: [\"rms(shaking_force, go) <= 30\"]}"})
    for (int trial = 0; trial < 2; ++trial) {
      CAPTURE(design);
      CAPTURE(trial);
      const FourBar bars = random_crank_rocker(random);
      const DesignSpace space = read(four_bar_spec(bars, false, movable_weights(random), design));
      const DesignReport report = find_design(space);
      REQUIRE(report.outcome.within_limits);
      check_least_mass(space, report, list_movable_weights(space));
    }
}

TEST_CASE("an element whose place is given by an angle vanishes completely") {
  std::mt19937 random(29);
  const FourBar bars = random_crank_rocker(random);
  std::string text = four_bar_spec(bars, false, "  w: {body: rocker, at: [\"r * cos(p)\", \"r * sin(p)\"], mass: m}\n",
                                   "{minimize: [{peak: torque, along: go}, {of: added-mass, weight: 1000}]}");
  text = replaced(text, "mp: 0.5,",
                  "mp: 0.5, m: {free: [0, 8], start: 0.5}, r: {free: [0.03, 0.15]}, p: {free: [-3, 3], start: 1},");
  const DesignSpace space = read(text);
  const DesignReport report = find_design(space);
  CHECK(report.outcome.x[index_of(space, "parameters.m")] == 0);
  CHECK(report.outcome.x[index_of(space, "parameters.r")] == space.start_values()[index_of(space, "parameters.r")]);
  CHECK(report.outcome.x[index_of(space, "parameters.p")] == 1);
  CHECK(report.added_mass == 0);
}

TEST_CASE("with sizes, too, a counterweight is as light as its longest arm allows") {
  std::mt19937 random(31);
  const FourBar bars = random_crank_rocker(random);
  std::string text = four_bar_spec(bars, false, "  w: {body: crank, at: [x, 0], mass: m}\n",
                                   "{minimize: {peak: shaking_force, along: go}}");
  text = replaced(text, "mp: 0.5,", "mp: 0.5, m: {free: [0, 9]}, x: {free: [-0.1, 0], start: -0.02},");
  text = replaced(text, "inertia: 0.004", "inertia: {free: {values: [0.003, 0.004]}}");
  const DesignSpace space = read(text);
  const DesignReport report = find_design(space);
  CHECK(report.outcome.x[index_of(space, "parameters.x")] == -0.1);
  CHECK(report.outcome.x[index_of(space, "parameters.m")] > 0);
}

namespace {

/// An arm of 3 kg whose weight a spring from above bears.
std::string spring_arm(const std::string& parameters, const std::string& free_length, const std::string& weights,
                       const std::string& design) {
  return fmt::format(R"(space: planar
gravity: [0, -9.81]
parameters: {}
ground: {{points: {{O: [0, 0], S: [0, h]}}}}
bodies:
  arm: {{mass: 3, com: [0.3, 0], inertia: 0.05, points: {{O: [0, 0], P: [s, 0]}}}}
joints:
  A: {{type: revolute, connects: [ground.O, arm.O]}}
actuators: [A]
springs:
  sp: {{between: [ground.S, arm.P], stiffness: k, free_length: {}}}
{}motion: {{duration: 1, samples: 41, from: {{joints: {{A: -0.5}}}}, to: {{joints: {{A: 1.3}}}}}}
trajectories: {{go: {{law: cycloidal, drive: joints}}}}
design: {}
)",
                     parameters, free_length, weights, design);
}

/// The set of solutions as equal as the start values.
balance::design::SolutionSet solutions_like_start(const DesignSpace& space) {
  const balance::design::DesignProblem problem = balance::design::make_design_problem(space, {});
  balance::design::SearchBudget budget(100);
  const balance::design::SolverContext context(problem, budget);
  const balance::design::ScaledObjective objective(context, *problem.objective);
  const VectorX& u = context.scaling.start();
  return analyse_solution_set(context, &objective, context.conditions_at(u), u);
}

}  // namespace

TEST_CASE("a family of equal springs is followed, and nothing is said where a figure can still be lowered") {
  // Scaling the triangle of the spring by f and its stiffness by 1 / f² changes no torque. The numbers are the optimum by
  // a closed form of the spring's torque, minimised by numpy; f = 0.97 keeps off the bounds.
  const double f = 0.97;
  const auto family = [&](double stiffness) {
    return fmt::format(
        "{{k: {{free: [0, 2000], start: {}}}, h: {{free: [0.05, 0.4], start: {}}}, s: {{free: [0.05, 0.25], start: "
        "{}}}, "
        "l0: {{free: [0, 0.2], start: {}}}}}",
        stiffness / (f * f), 0.16003942 * f, 0.11265302 * f, 0.05090066 * f);
  };
  const DesignSpace space = read(spring_arm(family(770.9067), "l0", "", "{minimize: {peak: torque}}"));
  const balance::design::SolutionSet set = solutions_like_start(space);
  CHECK(set.optimal_dimension == 1);
  CHECK(set.free_variables.size() == 4);
  const balance::design::SolutionSet elsewhere =
      solutions_like_start(read(spring_arm(family(900), "l0", "", "{minimize: {peak: torque}}")));
  CHECK(elsewhere.optimal_dimension == -1);
}

TEST_CASE("the ends of a spring without stiffness may be anywhere") {
  const DesignSpace space =
      read(spring_arm("{k: {free: [0, 2000], start: 0}, h: {free: [0.05, 0.4], start: 0.2}, "
                      "s: {free: [0.05, 0.25], start: 0.1}, m: {free: [0, 20], start: 9}}",
                      "0", "counterweights: {w: {body: arm, at: [-0.1, 0], mass: m}}\n",
                      "{goal: static, minimize: {peak: \"spring_force[sp]\"}}"));
  const balance::design::SolutionSet set = solutions_like_start(space);
  CHECK(set.optimal_dimension == 2);
  CHECK(set.free_variables == std::vector<int>{static_cast<int>(index_of(space, "parameters.h")),
                                               static_cast<int>(index_of(space, "parameters.s"))});
}

TEST_CASE("no point of a front is dominated within its tolerance, and its end without added mass has none") {
  std::mt19937 random(37);
  const FourBar bars = random_crank_rocker(random);
  DesignSpace space = read(four_bar_spec(
      bars, false, movable_weights(random),
      "{front: {of: [{peak: \"shaking_moment about ground.D\", along: go}, {peak: \"shaking_force[y]\", along: go}, "
      "added-mass], points: 6}}"));
  balance::DesignStudyOptions options;
  options.search = space.start.design.search;
  options.compare_trajectories = false;
  const balance::design::ParetoFront front = compute_pareto_front(space, options);
  REQUIRE(front.points.size() >= 4);
  VectorX low = front.points.front().values, high = low;
  for (const balance::design::ParetoPoint& point : front.points) {
    low = low.cwiseMin(point.values);
    high = high.cwiseMax(point.values);
  }
  CHECK(low[2] == 0);
  const VectorX slack = 1e-5 * (high - low);
  for (const balance::design::ParetoPoint& one : front.points)
    for (const balance::design::ParetoPoint& other : front.points) {
      const bool is_nowhere_worse = (other.values.array() <= (one.values + slack).array()).all();
      CHECK_FALSE((is_nowhere_worse && (other.values.array() < (one.values - slack).array()).any()));
    }
}
