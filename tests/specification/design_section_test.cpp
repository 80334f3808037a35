#include "balance/motion/simulation/simulate.hpp"

#include "specs.hpp"

#include <filesystem>

using namespace balance;
using namespace balance::specification;

namespace {

const std::string as_written = "design: {goal: static, minimize: added-mass}";

/// The planar spec with this as its last line: line 37, where values begin in column 9.
std::string designing(const std::string& design) { return specs::with(specs::planar, as_written, "design: " + design); }

study::DesignRequest request(const std::string& design) { return specs::read(designing(design)).design; }

/// What is wrong with a text for `--minimize`.
std::string objective_complaint(const std::string& text) {
  try {
    read_objective(text, specs::read(specs::planar));
  } catch (const SpecError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a goal is one name or a list of names") {
  CHECK(request("{goal: static}").goals == std::vector<Goal>{{GoalKind::statics}});
  CHECK(request("{goal: [force, fully-decoupled]}").goals ==
        std::vector<Goal>{{GoalKind::force}, {GoalKind::decoupled, true}});
  CHECK(request("{minimize: added-mass}").goals.empty());
}

TEST_CASE("every goal can be designed for") {
  for (const std::string& name : study::goal_names()) {
    const auto goals = request("{goal: " + name + "}").goals;
    REQUIRE(goals.size() == 1);
    CHECK(goal_name(goals[0]) == name);
  }
}

TEST_CASE("what to minimize is a size, a figure of a quantity along a trajectory, or a weighted sum of such") {
  const auto sizes = request("{minimize: [added-mass, added-inertia, {of: total-mass, weight: 0.5}]}").minimize;
  REQUIRE(sizes.size() == 3);
  CHECK(sizes[0].size == ObjectiveTerm::Size::added_mass);
  CHECK(sizes[1].size == ObjectiveTerm::Size::added_inertia);
  CHECK(sizes[2].size == ObjectiveTerm::Size::total_mass);
  CHECK(sizes[0].weight == 1);
  CHECK(sizes[2].weight == 0.5);

  const auto figures = request(
                           "{minimize: [{rms: shaking_force, along: swing, weight: \"l / 2\"}, "
                           "{peak: \"joint_force[J2]\"}, {mean: power}, {range: \"torque[J1]\"}]}")
                           .minimize;
  REQUIRE(figures.size() == 4);
  CHECK(figures[0].size == ObjectiveTerm::Size::none);
  CHECK(figures[0].figure == Statistic::rms);
  CHECK(figures[0].quantity == "shaking_force");
  CHECK(figures[0].trajectory == "swing");
  CHECK(figures[0].weight == 0.25);
  CHECK(figures[1].figure == Statistic::peak);
  CHECK(figures[1].quantity == "joint_force[J2]");
  CHECK(figures[1].trajectory == "line");  // the first one that is declared
  CHECK(figures[2].figure == Statistic::mean);
  CHECK(figures[3].figure == Statistic::range);
}

TEST_CASE("trajectories that a motion brings by itself may be minimized along") {
  CHECK(request("{minimize: {peak: shaking_force, along: bang-bang}}").minimize[0].trajectory == "bang-bang");
}

TEST_CASE("search options that are not given keep their defaults") {
  const study::SearchOptions some = request("{search: {global: isres, seed: 7, seconds: \"2 * l\"}}").search, defaults;
  CHECK(some.global == "isres");
  CHECK(some.seed == 7);
  CHECK(some.max_time == 1);
  CHECK(some.local == defaults.local);
  CHECK(some.max_restarts == defaults.max_restarts);
  CHECK(some.max_evaluations == defaults.max_evaluations);
  const study::SearchOptions others = request("{search: {local: sbplx, restarts: 3, evaluations: 1.0e+8}}").search;
  CHECK(others.local == "sbplx");
  CHECK(others.max_restarts == 3);
  CHECK(others.max_evaluations == 100'000'000);
}

TEST_CASE("mistakes in what to design for are named") {
  const specs::Mistake mistakes[] = {
      {"{goal: static,", "{goal: statics,",
       "s.yaml:37:16: design.goal: expected a goal (static, gyroscopic, gyroscopic-independent, decoupled, force,"},
      {"{goal: static,", "{goal: [],", "s.yaml:37:16: design.goal: expected at least one goal, found an empty list"},
      {"{goal: static,", "{goal: [static, force, static],",
       "s.yaml:37:32: design.goal[2]: expected each goal only once, found 'static' again"},
      {"{goal: static,", "{gaol: static,",
       "s.yaml:37:10: design.gaol: unknown key: expected goal, speeds, minimize, front, subject_to, choose, "
       "all_different, assembly_mode, search, for, across or adapt, found 'gaol'; nearest is 'goal'"},
      {"minimize: added-mass", "minimize: add-mass",
       "s.yaml:37:34: design.minimize: expected what to minimize (added-mass, added-inertia, total-mass, part-mass or "
       "price, or a figure "
       "along a trajectory such as {rms: torque}), found 'add-mass'; nearest is 'added-mass'"},
      {"minimize: added-mass", "minimize: ~", "s.yaml:37:34: design.minimize: expected what to minimize"},
      {"minimize: added-mass", "minimize: []", "s.yaml:37:34: design.minimize: expected at least one term"},
      {"minimize: added-mass", "minimize: [added-mass, {weight: 1}]",
       "s.yaml:37:47: design.minimize[1]: missing key: expected 'of', 'peak', 'rms', 'mean', 'range', 'minimum' or "
       "'maximum', found only "
       "weight"},
      {"minimize: added-mass", "minimize: {of: added-mass, along: line}",
       "s.yaml:37:58: design.minimize.along: expected no 'along' with 'of'"},
      {"minimize: added-mass", "minimize: {of: torque}", "s.yaml:37:39: design.minimize.of: expected what to minimize"},
      {"minimize: added-mass", "minimize: {rms: torque, peak: torque}",
       "s.yaml:37:40: design.minimize.rms: expected a quantity (torque[J1], torque[J2], force[D.slide], power, "},
      {"minimize: added-mass", "minimize: {rms: power, peak: power}",
       "s.yaml:37:53: design.minimize.peak: expected one of 'of', 'peak', 'rms', 'mean', 'range', 'minimum' and "
       "'maximum', found a second "
       "one"},
      {"minimize: added-mass", "minimize: {rms: powr}", "s.yaml:37:40: design.minimize.rms: expected a quantity"},
      {"minimize: added-mass", "minimize: {rms: power, along: lime}",
       "s.yaml:37:54: design.minimize.along: expected a trajectory (line, swing, via, cycloid or bang-bang), found "
       "'lime'; nearest is 'line'"},
      {"minimize: added-mass", "minimize: {rms: power, weight: -1}",
       "s.yaml:37:55: design.minimize.weight: must not be negative: expected a weight ≥ 0, found -1"},
      {"minimize: added-mass", "minimize: {rms: power, weight: {free: [0, 1]}}",
       "s.yaml:37:55: design.minimize.weight: expected a weight, a number or an expression, found a mapping"},
      {"minimize: added-mass", "search: {global: crss}",
       "s.yaml:37:41: design.search.global: expected a global method (direct, crs, isres, esch or mlsl), found 'crss'; "
       "nearest is 'crs'"},
      {"minimize: added-mass", "search: {local: newton}",
       "s.yaml:37:40: design.search.local: expected a local method (auto, slsqp, auglag, cobyla, bobyqa or sbplx), "
       "found 'newton'"},
      {"minimize: added-mass", "search: {restarts: 0}",
       "s.yaml:37:43: design.search.restarts: expected a whole number from 1 to 10000, found '0'"},
      {"minimize: added-mass", "search: {evaluations: 1.5}",
       "s.yaml:37:46: design.search.evaluations: expected a whole number from 1 to 100000000, found '1.5'"},
      {"minimize: added-mass", "search: {seed: -1}", "s.yaml:37:39: design.search.seed: expected a whole number"},
      {"minimize: added-mass", "search: {seconds: 0}",
       "s.yaml:37:42: design.search.seconds: must be positive: expected a number of seconds > 0, found 0"},
      {"minimize: added-mass", "search: {seconds: {free: [1, 2]}}",
       "s.yaml:37:42: design.search.seconds: expected a number of seconds, found a mapping"},
      {"minimize: added-mass", "search: {second: 1}",
       "s.yaml:37:33: design.search.second: unknown key: expected global, local, seed, restarts, evaluations or "
       "seconds, found 'second'; nearest is 'seconds'"},
  };
  specs::check(specs::planar, mistakes);
}

TEST_CASE("a figure needs a spec with a trajectory") {
  const std::string still = R"(
space: planar
bodies: {a: {mass: 1, com: [0.1, 0], inertia: 0.1}}
joints: {J: {type: revolute, connects: [ground.origin, a.origin]}}
actuators: [J]
design: {minimize: )";
  CHECK(specs::complaint(still + "{rms: torque}}").find("design.minimize: expected a spec with a trajectory") !=
        std::string::npos);
  CHECK(specs::complaint(still + "{rms: torque, along: cycloid}}")
            .find("design.minimize.along: expected a spec with a trajectory, found 'cycloid' but no motion") !=
        std::string::npos);
  CHECK(specs::complaint(still + "added-mass}").empty());
}

TEST_CASE("a mistake elsewhere is not turned into one about what to minimize") {
  const std::string text =
      specs::with(designing("{minimize: {rms: power, along: swing}}"), "swing: {law", "swing: {lwa");
  CHECK(specs::complaint(text).find("s.yaml:23:11: trajectories.swing.lwa: unknown key") == 0);
}

TEST_CASE("--minimize takes what minimize takes") {
  const Study study = specs::read(specs::planar);
  CHECK(read_objective("total-mass", study)[0].size == ObjectiveTerm::Size::total_mass);
  CHECK(read_objective("rms: torque[J1]", study)[0].quantity == "torque[J1]");
  const auto terms = read_objective("[{peak: power, along: via, weight: 2}, added-mass]", study);
  REQUIRE(terms.size() == 2);
  CHECK(terms[0].trajectory == "via");
  CHECK(terms[0].weight == 2);
}

TEST_CASE("mistakes in --minimize are named") {
  CHECK(objective_complaint("") == "--minimize: expected what to minimize, found an empty text");
  CHECK(objective_complaint("mass").find(
            "--minimize: expected what to minimize (added-mass, added-inertia, total-mass") == 0);
  CHECK(objective_complaint("{rms: powr}").find("--minimize: rms: expected a quantity (torque[J1]") == 0);
  CHECK(objective_complaint("[{rms: power, along: lin}]").find("--minimize: [0].along: expected a trajectory (line,") ==
        0);
  CHECK(objective_complaint("{rms: power, rms: power}").find("--minimize: rms: expected each key only once") == 0);
  CHECK(objective_complaint("{rms: power").find("--minimize: expected YAML, found a syntax error") == 0);
  CHECK(objective_complaint("{rms: power, weight: l}").find("--minimize: weight: expected a number") == 0);
}

TEST_CASE("the quantities that may be minimized are those that a simulation measures") {
  // Turning actuators, sliding ones, both kinds, in the plane and in space.
  for (const char* name : {"3rrr", "scara", "stewart", "spring-press", "slider-crank"}) {
    Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + name + ".yaml");
    REQUIRE(!study.trajectories.empty());
    study.trajectories[0].samples = 5;
    const RunResult result = simulate(study.mechanism, study.trajectories[0]);
    REQUIRE(!result.metrics.empty());
    for (const Metric& metric : result.metrics) CHECK_NOTHROW(read_objective("rms: " + metric.quantity, study));
    std::string unknown;
    try {
      read_objective("rms: nothing", study);
    } catch (const SpecError& error) {
      unknown = error.what();
    }
    const bool torque = std::any_of(result.metrics.begin(), result.metrics.end(),
                                    [](const Metric& metric) { return metric.quantity == "torque"; });
    CHECK((unknown.find("(torque, ") != std::string::npos) == torque);
  }
}
