#include "balance/interface/comparison/comparison.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace balance;
using namespace balance::comparison;
using Names = std::vector<std::string>;

TEST_CASE("a run is called by its file's stem") {
  CHECK(make_run_names({{"out/original.h5", ""}, {"bang-bang.v2.h5", ""}}) == Names{"original", "bang-bang.v2"});
}

TEST_CASE("equal stems get their folders before them") {
  CHECK(make_run_names({{"old/run.h5", ""}, {"new/run.h5", ""}, {"third.h5", ""}}) ==
        Names{"old/run", "new/run", "third"});
  CHECK(make_run_names({{"a/x/run.h5", ""}, {"b/x/run.h5", ""}}) == Names{"a/x/run", "b/x/run"});
}

TEST_CASE("the same file twice gets a number") {
  CHECK(make_run_names({{"run.h5", ""}, {"run.h5", ""}, {"./run.h5", ""}}) == Names{"run", "run-2", "run-3"});
  CHECK(make_run_names({{"run.h5", ""}, {"run.h5", ""}, {"run-2.h5", ""}}) == Names{"run", "run-3", "run-2"});
}

TEST_CASE("runs of a design file are called by their groups") {
  CHECK(make_run_names({{"design.h5", "before/cycloid"}, {"design.h5", "after/cycloid"}}) ==
        Names{"before/cycloid", "after/cycloid"});
  CHECK(make_run_names({{"one.h5", "after/cycloid"}, {"two.h5", "after/cycloid"}}) ==
        Names{"one:after/cycloid", "two:after/cycloid"});
}

TEST_CASE("only the first may be called base") {
  CHECK(make_run_names({{"base.h5", ""}, {"other.h5", ""}}) == Names{"base", "other"});
  CHECK(make_run_names({{"other.h5", ""}, {"out/base.h5", ""}}) == Names{"other", "out/base"});
  CHECK(make_run_names({{"other.h5", ""}, {"base.h5", ""}}) == Names{"other", "base-2"});
}

TEST_CASE("names are never alike") {
  const Names names = make_run_names(
      {{"a.h5", ""}, {"a.h5", ""}, {"a-2.h5", ""}, {"b/a.h5", ""}, {"base.h5", ""}, {"base.h5", ""}, {"b/a.h5", "a"}});
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) CHECK(names[i] != names[j]);
  }
}

TEST_CASE("the worst reaction stands before the reactions, each figure for itself") {
  RunResult result;
  result.metrics = {
      {"torque", "N m", 9}, {"joint_force[A]", "N", 5, 0.1, 4, 3, 2}, {"joint_force[B]", "N", 7, 0.2, 1, 6, 1}};
  result.energy = 3;
  const MetricTable table = make_metric_table("run", result);
  REQUIRE(table.metrics.size() == 4);
  const Metric& worst = table.metrics[1];
  CHECK(worst.quantity == "joint_force");
  CHECK(worst.peak == 7);
  CHECK(worst.peak_time == 0.2);
  CHECK(worst.rms == 4);
  CHECK(worst.mean == 6);
  CHECK(worst.range == 2);
  CHECK(table.energy == 3);
  CHECK(find_metric(table, "joint_moment") == nullptr);
  CHECK(std::isnan(find_figure(table, Statistic::rms, "joint_moment")));
  CHECK(find_figure(table, Statistic::mean, "joint_force[B]") == 6);
}

TEST_CASE("the worst of different units does not exist") {
  RunResult result;
  result.metrics = {{"joint_force[A]", "N", 5}, {"joint_force[B]", "lbf", 7}};
  CHECK(find_metric(make_metric_table("run", result), "joint_force") == nullptr);
}
