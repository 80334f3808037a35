// Elements that are needed at all: how many a mechanism cannot do without is known from its linearly independent vectors.

#include "balance/foundation/numerics/random.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "load_cases.hpp"

#include <fmt/format.h>

#include <map>

using namespace load_cases;

namespace {

std::string with(const std::string& config, const std::string& more, const std::string& choice) {
  const std::string text = replaced(file_text(config), "counterweights:\n", "counterweights:\n" + more);
  return replaced(text, "goal: force", "goal: force, minimize: added-mass, choose: " + choice);
}

int kept(const DesignReport& report) {
  int count = 0;
  for (const auto& choice : report.outcome.selection->kept)
    count += static_cast<int>(std::count(choice.begin(), choice.end(), true));
  return count;
}

void check_fewest(const DesignReport& report, int count) {
  CHECK(report.outcome.status == DesignStatus::balanced);
  REQUIRE(report.outcome.selection);
  CHECK(report.outcome.selection->min_count == count);
  CHECK(report.outcome.selection->is_min_count_proved);
  CHECK(kept(report) == count);
  CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
}

constexpr const char* for_four_bar =
    "  cw3: {body: coupler, at: [-0.05, -0.02], mass: {free: [0, 10]}}\n"
    "  cw4: {body: coupler, at: [0.4, 0.02], mass: {free: [0, 10]}}\n";
constexpr const char* for_five_bar = "  cw12: {body: coupler1, at: [-0.12, 0], mass: {free: [0, 30]}}\n";
constexpr const char* for_3rrr =
    "  cw_p: {body: platform, at: [0.05, 0.1], mass: {free: [0, 20]}}\n"
    "  cw_q: {body: coupler2, at: [0.28, 0], mass: {free: [0, 20]}}\n";

using Names = std::vector<std::string>;

/// A random mechanism whose links may each bear a counterweight with free mass and place.
struct RandomProblem {
  std::string mechanism;
  Names counterweights;
  std::map<std::string, std::string> text;  ///< of each counterweight

  /// @param names the counterweights that are offered
  DesignReport solve(const Names& names, const std::string& design) const {
    std::string spec = mechanism + (names.empty() ? "" : "counterweights:\n");
    for (const std::string& name : names) spec += "  " + name + ": " + text.at(name) + "\n";
    return find_design(read(spec + "design: {" + design + "}\n"));
  }
};

struct RandomLink {
  std::string name;
  double length;
  std::string more_points;
};

void add_links(RandomProblem& problem, balance::numerics::UniformRandom& random, const std::vector<RandomLink>& links) {
  problem.mechanism += "bodies:\n";
  const double box = random(0.15, 0.3);
  for (const RandomLink& link : links) {
    const double m = random(0.5, 1.6), l = link.length;
    problem.mechanism +=
        fmt::format("  {}: {{mass: {}, com: [{}, {}], inertia: {}, points: {{O: [0, 0], E: [{}, 0]{}}}}}\n", link.name,
                    m, random(0.2, 0.7) * l, random(-0.15, 0.15) * l, m * l * l / 8, l, link.more_points);
    problem.counterweights.push_back("w_" + link.name);
    problem.text["w_" + link.name] = fmt::format(
        "{{body: {0}, at: [{{free: [-{1}, {1}]}}, {{free: [-{1}, {1}]}}], mass: {{free: [0, 60]}}}}", link.name, box);
  }
}

const std::string four_bar_joints =
    "joints:\n"
    "  A: {type: revolute, connects: [ground.A, crank.O]}\n"
    "  B: {type: revolute, connects: [crank.E, coupler.O]}\n"
    "  C: {type: revolute, connects: [coupler.E, rocker.E]}\n"
    "  D: {type: revolute, connects: [ground.D, rocker.O]}\n";

RandomProblem random_four_bar(std::uint64_t seed) {
  balance::numerics::UniformRandom random(seed);
  RandomProblem problem;
  problem.mechanism = fmt::format("space: planar\nground: {{points: {{A: [0, 0], D: [{}, 0]}}}}\n", random(0.36, 0.42));
  add_links(problem, random,
            {{"crank", random(0.08, 0.12), ""}, {"coupler", random(0.3, 0.4), ""}, {"rocker", random(0.25, 0.32), ""}});
  problem.mechanism += four_bar_joints +
                       "actuators: [A]\nassembly: {A: 0.5, B: 0.1, D: 1.8}\n"
                       "motion: {duration: 0.5, samples: 41, from: {joints: {A: 0.5}}, to: {joints: {A: 1.7}}}\n"
                       "trajectories: {go: {law: cycloidal, drive: joints}}\n";
  return problem;
}

RandomProblem random_six_bar(std::uint64_t seed) {
  balance::numerics::UniformRandom random(seed);
  RandomProblem problem;
  problem.mechanism = "space: planar\nground: {points: {A: [0, 0], D: [0.4, 0], G: [0.6, 0.35]}}\n";
  add_links(problem, random,
            {{"crank", 0.1, ""},
             {"coupler", 0.35, ", F: [0.17, 0.12]"},
             {"rocker", 0.25, ""},
             {"rod", 0.32, ""},
             {"out", 0.25, ""}});
  problem.mechanism += four_bar_joints +
                       "  F: {type: revolute, connects: [coupler.F, rod.O]}\n"
                       "  H: {type: revolute, connects: [rod.E, out.E]}\n"
                       "  G: {type: revolute, connects: [ground.G, out.O]}\n"
                       "actuators: [A]\nassembly: {A: 0.5, B: 0.1, D: 1.8, F: -0.3, G: 2.5}\n"
                       "motion: {duration: 0.5, samples: 41, from: {joints: {A: 0.5}}, to: {joints: {A: 1.3}}}\n"
                       "trajectories: {go: {law: cycloidal, drive: joints}}\n";
  return problem;
}

/// The least figure of the designs with at most `count` of the counterweights, each set solved without a choice;
/// infinite if no set of them does.
double min_over_all_sets(const RandomProblem& problem, std::size_t count, const std::string& design) {
  double min_figure = std::numeric_limits<double>::infinity();
  const std::size_t n = problem.counterweights.size();
  for (std::size_t set = 1; set < std::size_t{1} << n; ++set) {
    Names names;
    for (std::size_t k = 0; k < n; ++k)
      if ((set >> k & 1U) != 0) names.push_back(problem.counterweights[k]);
    if (names.size() != count) continue;
    const balance::design::DesignOutcome outcome = problem.solve(names, design).outcome;
    if (outcome.status == DesignStatus::balanced) min_figure = std::min(min_figure, outcome.objective);
  }
  return min_figure;
}

constexpr const char* designs[] = {"goal: force, minimize: added-mass",
                                   "goal: force, minimize: {rms: torque, along: go}"};
/// Gaps at which a design counts as proved, of both designs that are compared.
constexpr double proof_tolerance = 2e-6;

/// What is left out has no mass and is where it started; it is not a freedom of the design.
void check_left_out(const DesignReport& report) {
  const auto& kept = report.outcome.selection->kept;
  for (std::size_t c = 0; c < kept.size(); ++c)
    for (std::size_t k = 0; k < kept[c].size(); ++k) {
      if (kept[c][k]) continue;
      for (std::size_t i = 0; i < report.free_numbers.size(); ++i) {
        const auto& number = report.free_numbers[i];
        if (number.key_path.find("." + report.cardinality_constraints[c].elements[k].name + ".") == std::string::npos)
          continue;
        CHECK_MESSAGE(report.outcome.x[static_cast<Eigen::Index>(i)] == number.start, number.key_path);
        const auto& free = report.outcome.solution_set.free_variables;
        CHECK(std::find(free.begin(), free.end(), static_cast<int>(i)) == free.end());
      }
    }
}

}  // namespace

TEST_CASE("a four-bar needs two counterweights, a five-bar three, a 3RRR six") {
  check_fewest(find_design(read(with("four-bar-force-balance.yaml", for_four_bar, "{counterweights: least}"))), 2);
  check_fewest(find_design(read(with("5r-force-balance.yaml", for_five_bar, "{counterweights: least}"))), 3);
  check_fewest(find_design(read(with("3rrr-force-balance.yaml", for_3rrr, "{counterweights: least}"))), 6);
}

TEST_CASE("a count that is not min_count is impossible, with the one that is") {
  const DesignReport report = find_design(read(with("5r-force-balance.yaml", for_five_bar, "{counterweights: 2}")));
  CHECK(report.outcome.status == DesignStatus::infeasible);
  CHECK(report.outcome.is_proved_infeasible);
  CHECK(report.outcome.selection->min_count == 3);
  CHECK(report.outcome.selection->is_min_count_proved);
  CHECK(kept(report) <= 2);
}

TEST_CASE("among equal counts the least figure counts, as among all pairs") {
  const std::string offered = "{counterweights: {from: [cw11, cw12, cw21, cw22], most: 2}}";
  const std::string text = replaced(with("5r-force-balance.yaml", for_five_bar, offered),
                                    "goal: force, minimize: added-mass", "minimize: {rms: torque, along: cycloid}");
  const DesignReport best = find_design(read(text));
  CHECK(best.outcome.optimality == balance::design::Optimality::proved_global);
  double min_figure = 1e9;
  const std::vector<std::string> names = {"cw11", "cw12", "cw21", "cw22"};
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const DesignReport pair = find_design(
          read(replaced(text, "[cw11, cw12, cw21, cw22], most: 2", "[" + names[i] + ", " + names[k] + "], most: 0")));
      min_figure = std::min(min_figure, pair.outcome.objective);  // the other pair
    }
  CHECK(best.outcome.objective == doctest::Approx(min_figure).epsilon(1e-6));
}

TEST_CASE("what cannot vanish cannot be left out") {
  const std::string text =
      replaced(with("5r-force-balance.yaml", "  heavy: {body: crank1, at: [0, 0], mass: {free: [1, 2]}}\n",
                    "{counterweights: {from: [heavy]}}"),
               "minimize: added-mass, ", "");
  CHECK_THROWS_AS(find_design(read(text)), std::invalid_argument);
}

TEST_CASE("a choice is the best of all its sets, each solved without a choice, and proved") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    const RandomProblem problem = seed % 3 == 0 ? random_six_bar(seed) : random_four_bar(seed);
    const std::string design = designs[seed % 2];
    const std::size_t min_count = problem.counterweights.size() == 3 ? 2 : 3;
    const double min_mass = min_over_all_sets(problem, min_count, design);
    REQUIRE(std::isfinite(min_mass));
    for (const std::string& count : {fmt::format("{}", min_count), std::string("least")}) {
      CAPTURE(count);
      const DesignReport report =
          problem.solve(problem.counterweights, design + ", choose: {counterweights: " + count + "}");
      CHECK(report.outcome.status == DesignStatus::balanced);
      CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
      CHECK(report.outcome.objective == doctest::Approx(min_mass).epsilon(proof_tolerance));
      CHECK(report.outcome.lower_bound <= min_mass * (1 + proof_tolerance));
      CHECK(kept(report) == static_cast<int>(min_count));
      check_left_out(report);
      if (count == "least") check_fewest(report, static_cast<int>(min_count));
    }
    CHECK(min_over_all_sets(problem, min_count - 1, design) == std::numeric_limits<double>::infinity());
  }
}

TEST_CASE("a choice of all elements is the problem without a choice") {
  for (std::uint64_t seed = 11; seed <= 16; ++seed) {
    CAPTURE(seed);
    const RandomProblem problem = seed % 3 == 0 ? random_six_bar(seed) : random_four_bar(seed);
    const std::string design = designs[seed % 2];
    const DesignReport all = problem.solve(problem.counterweights, design);
    const DesignReport choice =
        problem.solve(problem.counterweights,
                      fmt::format("{}, choose: {{counterweights: {}}}", design, problem.counterweights.size()));
    CHECK(choice.outcome.status == all.outcome.status);
    CHECK(choice.outcome.optimality == all.outcome.optimality);
    CHECK(choice.outcome.objective == doctest::Approx(all.outcome.objective).epsilon(proof_tolerance));
    check_left_out(choice);
  }
}

TEST_CASE("a place along a line is chosen as exactly as one in a box") {
  RandomProblem problem = random_four_bar(21);
  problem.mechanism += "parameters: {p: {free: [-0.3, 0.3]}, q: {free: [-0.3, 0.3]}}\n";
  problem.text["w_crank"] = "{body: crank, at: [\"p * cos(0.3)\", \"p * sin(0.3)\"], mass: {free: [0, 60]}}";
  problem.text["w_rocker"] = "{body: rocker, at: [\"q * cos(-0.2)\", \"q * sin(-0.2)\"], mass: {free: [0, 60]}}";
  const DesignReport report = problem.solve(problem.counterweights, "goal: force, minimize: added-mass");
  CHECK(report.outcome.status == DesignStatus::balanced);
  CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
}

TEST_CASE("places in space are chosen exactly, although nothing depends on their height") {
  // About J2, 0.8 kg · 0.1 m = 0.4 kg · 0.2 m; about J1, 1.2 kg · 0.1 m + 1.2 kg · 0.3 m = 2.4 kg · 0.2 m.
  const DesignReport report = find_design(read(
      "space: spatial\n"
      "ground: {points: {O: [0, 0, 0]}}\n"
      "bodies:\n"
      "  l1: {mass: 1.2, com: [0.1, 0.02, 0.03], inertia: [0.02, 0.02, 0.02], points: {O: [0, 0, 0], E: [0.3, 0, "
      "0.05]}}\n"
      "  l2: {mass: 0.8, com: [0.1, 0.01, -0.02], inertia: [0.01, 0.01, 0.01], points: {O: [0, 0, 0]}}\n"
      "joints:\n"
      "  J1: {type: revolute, axis: [0, 0, 1], connects: [ground.O, l1.O]}\n"
      "  J2: {type: revolute, axis: [0, 1, 0], connects: [l1.E, l2.O]}\n"
      "counterweights:\n"
      "  w1: {body: l1, at: [{free: [-0.2, 0.2]}, {free: [-0.2, 0.2]}, {free: [-0.1, 0.1]}], mass: {free: [0, 20]}}\n"
      "  w2: {body: l2, at: [{free: [-0.2, 0.2]}, {free: [-0.2, 0.2]}, {free: [-0.1, 0.1]}], mass: {free: [0, 20]}}\n"
      "  v2: {body: l2, at: [-0.1, 0, {free: [-0.1, 0.1]}], mass: {free: [0, 20]}}\n"
      "actuators: [J1, J2]\n"
      "design: {goal: force, minimize: added-mass, choose: {counterweights: least}}\n"));
  check_fewest(report, 2);
  CHECK(report.outcome.objective == doctest::Approx(2.8).epsilon(proof_tolerance));
  check_left_out(report);
}

TEST_CASE("what is left out stays left out when places follow the load") {
  const std::string text =
      replaced(replaced(file_text("rr-adaptive.yaml"), "counterweights:\n",
                        "counterweights:\n  spare: {body: link1, at: [-0.3, 0], mass: {free: [0, 12]}}\n"),
               "  goal: static\n", "  goal: static\n  minimize: added-mass\n  choose: {counterweights: least}\n");
  const DesignReport report = find_design(read(text));
  CHECK(report.outcome.status == DesignStatus::balanced);
  CHECK(kept(report) == 0);
  REQUIRE(report.adaptive);
  CHECK(report.adaptive->law);
}

TEST_CASE("one place in all load cases is proved to be the best, and no better than in each case alone") {
  const std::string arm =
      replaced(replaced(replaced(file_text("rr-adaptive.yaml"), "mass: 12", "mass: {free: [0, 12]}"), "mass: 4",
                        "mass: {free: [0, 4]}"),
               "  goal: static\n  for: {mp: [0, 0.5, 1]}\n  adapt: [cw1.at, cw2.at]",
               "  minimize: {rms: torque, along: bang-bang}");
  const DesignReport both = find_design(read(arm + "  for: {mp: [0, 1]}\n"));
  CHECK(both.outcome.optimality == balance::design::Optimality::proved_global);
  for (const char* load : {"0", "1"}) {
    const DesignReport alone = find_design(read(replaced(arm, "mp: 0.5", std::string("mp: ") + load)));
    CHECK(alone.outcome.optimality == balance::design::Optimality::proved_global);
    CHECK(both.outcome.objective >= alone.outcome.objective * (1 - proof_tolerance));
  }
}
