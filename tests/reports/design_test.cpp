#include "../files/hdf5_reader.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "design_sample.hpp"

#include <nlohmann/json.hpp>

#include <doctest/doctest.h>

#include <limits>

using namespace balance;
using namespace balance::design;
using namespace balance::reports;
using sample::Folder;
using sample::Reader;

namespace {
const files::TextOptions one_line{.width = 1000};  // nothing is wrapped
}

TEST_CASE("a design says what was reached, the numbers, the conditions, the cost and the gain") {
  CHECK(design_text(sample::sample_design()) ==
        "made up: balanced exactly for static, with the least possible added mass\n"
        "3 conditions are met\n"
        "added mass: 10.0000 kg\n"
        "optimality: proved-best: nothing is below 10.0000, a gap of 0\n"
        "freedom: none: no other solution as good is near\n"
        "\n"
        "free number [SI]       lower  upper    before      value\n"
        "bodies.a.com[0]           -1      1  0.500000  -0.250000\n"
        "counterweights.b.mass      0     10         0    10.0000  at upper\n"
        "\n"
        "no  condition            before  after\n"
        " 1  a.mx + l1 b.m = 0      0.12    met\n"
        " 2  -l1^2 a.m + e.J = 0     met    met\n"
        "where l1 = 0.5 m\n"
        "3 holds for every disc that is symmetrical about its axis\n"
        "\n"
        "added mass     10 kg of counterweights and discs (everything that moves:\n"
        "  3 kg before, 13 kg after)\n"
        "added inertia  0.125 kg m^2 of them (everything that moves: 0.5 kg m^2 before,\n"
        "  0.625 kg m^2 after)\n"
        "\n"
        "trajectory cycloid\n"
        "quantity       unit  peak before    after  ratio  rms before    after  ratio\n"
        "torque[A]      N m       100.000  25.0000   0.25     50.0000  10.0000    0.2\n"
        "shaking_force  N         800.000        0      0     400.000        0      0\n"
        "\n"
        "trajectory a/b\n"
        "cannot be followed after: it stands still\n"
        "\n"
        "note: a note\n");
}

TEST_CASE("a compromise and an impossibility are not called solutions, and the proof is said once") {
  DesignReportData view = sample::sample_design();
  DesignOutcome& outcome = view.report.outcome;
  outcome.optimality = Optimality::local_optimum;
  outcome.status = DesignStatus::compromise;
  outcome.reason = "1 of 3 conditions stays open";
  CHECK(design_text(view, one_line)
            .find("made up: a compromise: not balanced for static\n1 of 3 conditions stays open\n") == 0);
  outcome.status = DesignStatus::infeasible;
  outcome.certificate = conditions::InfeasibilityCertificate{};
  outcome.certificate->statement = "a.m + b.m = 0 cannot hold: both are positive";
  outcome.reason = outcome.certificate->statement;
  const std::string text = design_text(view, one_line);
  CHECK(text.find("impossible: no choice of the free numbers balances it for static\na.m + b.m") != std::string::npos);
  CHECK(text.find("cannot hold") == text.rfind("cannot hold"));
  CHECK(text.find("impossibility: not proved\n") != std::string::npos);
  outcome.is_proved_infeasible = true;
  CHECK(design_text(view, one_line).find("impossibility: proved\n") != std::string::npos);
}

TEST_CASE("what is not proved the best shows what the least could be") {
  DesignReportData view = sample::sample_design();
  view.report.outcome.optimality = Optimality::local_optimum;
  view.report.outcome.search_summary = "6 starts";
  view.report.outcome.lower_bound = 8;
  CHECK(design_text(view, one_line)
            .find("made up: balanced exactly for static\n3 conditions are met\n"
                  "added mass: 10.0000 kg; at least 8.00000 kg is needed\n"
                  "optimality: local-best: the best of what was tried (6 starts), proved to be within 20 % of the "
                  "best\n") == 0);
  view.report.outcome.lower_bound = 1;  // says next to nothing
  CHECK(design_text(view, one_line).find("(6 starts), not shown to be the best\n") != std::string::npos);
}

TEST_CASE("a proof by trying all sizes says how many there are") {
  DesignReportData view = sample::sample_design();
  view.report.outcome.optimality = Optimality::proved_global;
  view.report.outcome.search_summary = "all 64 combinations of sizes";
  CHECK(design_text(view, one_line).find("were tried") == std::string::npos);
  view.report.outcome.effort.tried_all_combinations = true;
  CHECK(design_text(view, one_line).find("; all 64 combinations of sizes were tried\n") != std::string::npos);
}

TEST_CASE("the least there is stands only where it is proved (B6)") {
  DesignReportData view = sample::sample_design();
  for (const Optimality optimality :
       {Optimality::not_optimised, Optimality::local_optimum, Optimality::budget_exhausted}) {
    view.report.outcome.optimality = optimality;
    CHECK(design_text(view, one_line).find("there is") == std::string::npos);
    CHECK(nlohmann::json::parse(files::format_json(design_json(view, {})))["objective"]["global"] == false);
  }
  view.report.outcome.lower_bound = std::numeric_limits<double>::quiet_NaN();
  CHECK(design_text(view, one_line)
            .find("optimality: stopped: after the time limit of 60 s, not shown to be the best; "
                  "--seconds 240 allows more\n") != std::string::npos);
}

TEST_CASE("what a search leaves free is counted and named (B11)") {
  DesignReportData view = sample::sample_design();
  view.report.outcome.solution_set = {2, 1, {0, 1}};
  CHECK(design_text(view, one_line)
            .find("freedom: 1 is left, with the same added mass: one of many solutions; what may still "
                  "change: bodies.a.com[0], counterweights.b.mass\n") != std::string::npos);
  view.report.outcome.solution_set = {2, -1, {0, 1}};
  CHECK(design_text(view, one_line)
            .find("freedom: the conditions leave 2, used for a small added mass: bodies.a.com[0], "
                  "counterweights.b.mass\n") != std::string::npos);
}

TEST_CASE("without a goal nothing is called balanced (B12)") {
  DesignReportData view = sample::sample_design();
  view.report.outcome.status = DesignStatus::no_goal;
  CHECK(design_text(view, one_line).find("made up: the least possible added mass\n") == 0);
  view.report.outcome.optimality = Optimality::local_optimum;
  CHECK(design_text(view, one_line).find("made up: the smallest added mass that was found\n") == 0);
  view.report.outcome.status = DesignStatus::no_feasible_start;
  CHECK(nlohmann::json::parse(files::format_json(design_json(view, {})))["status"] == "not-found");
}

TEST_CASE("only the trajectories that the objective and the limits name are shown") {
  DesignReportData view = sample::sample_design();
  view.trajectories = {"cycloid"};
  CHECK(design_text(view).find("trajectory a/b") == std::string::npos);
  CHECK(design_text(view).find("\nalong a/b: see --verbose\n") != std::string::npos);
  CHECK(nlohmann::json::parse(files::format_json(design_json(view, {})))["trajectories"].size() == 2);
  CHECK(design_text(view, {.verbose = true}).find("trajectory a/b") != std::string::npos);
}

TEST_CASE("what got worse is said") {
  DesignReportData view = sample::sample_design();
  CHECK(design_text(view).find("worse than before") == std::string::npos);
  std::vector<Metric>& after = view.report.comparisons[0].after.metrics;
  after[1].peak = 984;
  after[1].rms = 3200;
  CHECK(design_text(view, one_line).find("worse than before along cycloid: shaking_force (peak +23 %, rms x 8)\n") !=
        std::string::npos);
}

TEST_CASE("changes drop what round-off leaves, but not what is small") {
  TrajectoryComparison c = sample::sample_design().report.comparisons[0];
  auto changes = list_metric_changes(c);
  REQUIRE(changes.size() == 4);
  CHECK(changes[2].after == 0);
  c.after.metrics[1].peak = 1e-11;  // the terms before leave 2e-12
  CHECK(list_metric_changes(c)[2].after == 1e-11);
  std::swap(c.before, c.after);
  c.after.metrics[1].rms = 7;
  c.before.metrics[1].rms = 1e-13;
  changes = list_metric_changes(c);
  CHECK(changes[3].before == 0);
  CHECK(changes[3].after == 7);
}

TEST_CASE("a design tells what a user should know of the motions before and after (A1)") {
  DesignReportData view = sample::sample_design();
  view.report.comparisons[0].before.outcome.notes = {"both", "first"};
  view.report.comparisons[0].after.outcome.notes = {"both", "then"};
  CHECK(design_text(view, one_line).find("note: both\nnote, before: first\nnote, after: then\n") != std::string::npos);
  const auto json = nlohmann::json::parse(files::format_json(design_json(view, {})))["trajectories"][0];
  CHECK(json["before"]["notes"] == nlohmann::json({"both", "first"}));
  CHECK(json["after"]["notes"] == nlohmann::json({"both", "then"}));
}

TEST_CASE("objectives in words, with their units") {
  ObjectiveTerm mass;
  mass.size = ObjectiveTerm::Size::added_mass;
  ObjectiveTerm torque;
  torque.quantity = "torque";
  torque.trajectory = "cycloid";
  torque.weight = 0.5;
  CHECK(objective_text({torque, mass}) == "0.5 rms of torque along cycloid + added mass");
  CHECK(simulation::objective_unit({mass}, {}) == "kg");
  CHECK(simulation::objective_unit({mass, torque}, {}) == "");
  torque.weight = 1;
  Mechanism m;
  m.coordinates = {{"S", 0, 0, CoordinateKind::length}, {"A", 1, 0, CoordinateKind::angle}};
  m.actuators = {0, 1};
  torque.quantity = "torque[S]";
  CHECK(simulation::objective_unit({torque}, m) == "N");
  torque.quantity = "torque[A]";
  CHECK(simulation::objective_unit({torque}, m) == "N m");
  CHECK(objective_text({}) == "");
}

TEST_CASE("a design in JSON holds the same, unrounded") {
  const auto json = nlohmann::json::parse(files::format_json(design_json(sample::sample_design(), {"out.yaml"})));
  CHECK(json["status"] == "balanced");
  CHECK(json["method"] == "affine");
  CHECK(json["proof"].is_null());
  CHECK(json["objective"]["global"] == true);
  CHECK(json["optimality"] == "proved-best");
  CHECK(json["objective"]["gap"] == 0.0);
  CHECK(json["freedom"]["left"] == 0);
  CHECK(json["mass"]["added"] == 10.0);
  CHECK(json["free_numbers"][1]["at_bound"] == "upper");
  CHECK(json["free_numbers"][0]["value"] == -0.25);
  CHECK(json["conditions"][0]["residual_before"] == 0.125);
  CHECK(json["conditions"][0]["residual"] == 0.0);
  CHECK(json["mass"]["after"] == 13.0);
  CHECK(json["trajectories"][0]["changes"][0]["ratio"] == 0.25);
  CHECK(json["trajectories"][1]["after"]["outcome"]["status"] == "drive-singularity");
  CHECK(json["files"] == std::vector<std::string>{"out.yaml"});
}

TEST_CASE("a design's file holds numbers, conditions and both runs of every trajectory, to the last bit") {
  const Folder folder;
  const DesignReportData view = sample::sample_design();
  write_design(folder / "out.h5", view, sample::description());
  const Reader file(folder / "out.h5");
  CHECK(file.texts("free_number") == std::vector<std::string>{"bodies.a.com[0]", "counterweights.b.mass"});
  CHECK(file.numbers("lower") == std::vector<double>{-1, 0});
  CHECK(file.numbers("start") == std::vector<double>{0.5, 0});
  CHECK(file.numbers("value") == std::vector<double>{-0.25, 10});
  CHECK(file.sizes("condition_matrix") == std::vector<hsize_t>{3, 5});
  CHECK(file.numbers("condition_matrix") == std::vector<double>{0, 1, 0.5, 0, 0, -0.25, 0, 0, 0, 1, 0, 0, 0, 1, 0});
  CHECK(file.number_attribute("condition_matrix", "gap") == std::vector<double>{1e14});
  CHECK(file.numbers("residual_before") == std::vector<double>{0.125, 0, 0});
  CHECK(file.texts("condition")[0] == "a.mx + l1 b.m = 0");
  CHECK(file.numbers("mass_after") == std::vector<double>{13});
  CHECK(file.text_attribute("/", "status") == "balanced");
  CHECK(file.text_attribute("/", "objective") == "added mass");
  const RunResult& before = view.report.comparisons[0].before;
  CHECK(file.numbers("before/cycloid/joint_force") ==
        std::vector<double>(before.joint_force.data(), before.joint_force.data() + before.joint_force.size()));
  CHECK(file.numbers("after/cycloid/metrics/peak") == std::vector<double>{25, 1e-12});
  CHECK(file.text_attribute("after/a_b", "status") == "drive-singularity");
  CHECK(file.text_attribute("after/a_b", "trajectory") == "a/b");
  CHECK_FALSE(file.has("after/a_b/time"));
  for (const std::string& name : file.datasets())
    for (const std::string& dimension : file.dimensions(name)) CHECK_MESSAGE(dimension != "-", name);
}

TEST_CASE("a design without conditions or trajectories still makes a file, the same bytes each time") {
  const Folder folder;
  DesignReportData view = sample::sample_design();
  view.report.comparisons.clear();
  view.conditions.conditions.matrix.resize(0, 5);
  for (const char* name : {"a", "b"}) write_design(folder / name, view, sample::description());
  CHECK_FALSE(Reader(folder / "a").has("condition"));
  CHECK(sample::content(folder / "a") == sample::content(folder / "b"));
}
