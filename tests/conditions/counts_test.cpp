/// Numbers of conditions that are known by hand or from the literature, and what the conditions do not depend on.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace balance;
using namespace balance::conditions;

namespace {

Mechanism load(const std::string& file) { return read_spec_file(std::string(BALANCE_CONFIGS "/") + file).mechanism; }

int rank_of(const std::string& file, const std::string& goal) {
  const Conditions conditions = derive_conditions(load(file), {study::find_goal(goal).value()});
  CHECK(conditions.status == ConditionsStatus::done);
  CHECK(conditions.singular_value_gap > 1e6);
  return conditions.rank;
}

std::vector<std::string> texts(const Conditions& conditions) {
  std::vector<std::string> all;
  for (Eigen::Index row = 0; row < conditions.rank; ++row)
    all.push_back(linear_combination_text(conditions.parameters, conditions.matrix.row(row)));
  return all;
}

/// Every row of one is a combination of the other's rows, and there are as many.
bool same_conditions(const Conditions& a, const Conditions& b) {
  return a.rank == b.rank && a.pivots == b.pivots && (a.matrix - b.matrix).cwiseAbs().maxCoeff() < 1e-9;
}

}  // namespace

TEST_CASE("a five-bar has 6 static, 8 gyroscopic, 9 independent gyroscopic, 6 force and 11 dynamic conditions") {
  CHECK(rank_of("5r.yaml", "static") == 6);
  CHECK(rank_of("5r.yaml", "gyroscopic") == 8);
  CHECK(rank_of("5r.yaml", "gyroscopic-independent") == 9);
  CHECK(rank_of("5r.yaml", "force") == 6);
  CHECK(rank_of("5r.yaml", "dynamic") == 11);
}

TEST_CASE(
    "a four-bar has the four force conditions of Berkof and Lowen, two for each link that is pivoted to the frame") {
  CHECK(rank_of("four-bar.yaml", "force") == 4);
}

TEST_CASE(
    "a parallelogram has fewer conditions than a four-bar: it is not the antiparallelogram that it can fold into") {
  CHECK(rank_of("parallelogram.yaml", "force") == 2);
  CHECK(rank_of("four-bar.yaml", "force") == 4);
}

TEST_CASE("a serial arm's gyroscopic conditions are the same in both senses of the word") {
  for (const char* file : {"planar-rrr.yaml", "spatial-rrr.yaml", "scara.yaml", "rr.yaml"}) {
    CAPTURE(file);
    CHECK(rank_of(file, "gyroscopic") == rank_of(file, "gyroscopic-independent"));
  }
}

TEST_CASE("conditions do not depend on the configurations that they were found at") {
  for (const char* file : {"3rrr.yaml", "5r.yaml", "four-bar.yaml", "spatial-slider-crank.yaml", "delta.yaml"})
    for (const GoalKind goal : {GoalKind::force, GoalKind::dynamic}) {
      CAPTURE(file);
      const Conditions one = derive_conditions(load(file), {{goal}}), other = [&] {
        ConditionOptions options;
        options.seed = 99;
        return derive_conditions(load(file), {{goal}}, options);
      }();
      CHECK(same_conditions(one, other));
    }
}

TEST_CASE("several goals together ask for what each of them asks for") {
  const Mechanism five_bar = load("5r.yaml");
  const Conditions both = derive_conditions(five_bar, {{GoalKind::force}, {GoalKind::moment}});
  CHECK(same_conditions(both, derive_conditions(five_bar, {{GoalKind::dynamic}})));
}

TEST_CASE("every condition is solved for a parameter of its own with coefficient one") {
  for (const char* file : {"3rrr.yaml", "spatial-rrr.yaml", "stewart.yaml"}) {
    const Conditions conditions = derive_conditions(load(file), {{GoalKind::dynamic}});
    for (Eigen::Index row = 0; row < conditions.rank; ++row) {
      const int pivot = conditions.pivots[static_cast<std::size_t>(row)];
      CHECK(conditions.matrix(row, pivot) == 1);
      CHECK((conditions.matrix.col(pivot).array() != 0).count() == 1);
    }
  }
}

TEST_CASE("the static conditions of a planar RRR arm read as a designer would write them") {
  Mechanism arm = load("planar-rrr.yaml");
  arm.discs.clear();
  const auto lines = texts(derive_conditions(arm, {{GoalKind::statics}}));
  const std::vector<std::string> expected = {
      "link1.mx + 0.5 link2.m + 0.5 link3.m", "link1.my", "link2.mx + 0.4 link3.m", "link2.my", "link3.mx", "link3.my"};
  CHECK(lines == expected);
}

TEST_CASE("without gravity the static goal asks for nothing, and says so") {
  const Conditions conditions = derive_conditions(load("3rrr.yaml"), {{GoalKind::statics}});
  CHECK(conditions.status == ConditionsStatus::done);
  CHECK(conditions.rank == 0);
  REQUIRE(conditions.notes.size() == 1);
  CHECK(conditions.notes[0].find("no gravity") != std::string::npos);
}

TEST_CASE("a goal that speaks of actuators or of the tool needs them") {
  Mechanism arm = load("planar-rrr.yaml");
  arm.actuators.pop_back();
  CHECK(derive_conditions(arm, {{GoalKind::decoupled}}).status == ConditionsStatus::mismatch);
  arm.tool.reset();
  CHECK(derive_conditions(arm, {{GoalKind::proportional}}).status == ConditionsStatus::mismatch);
}

TEST_CASE("loops that cannot be closed have no conditions") {
  Mechanism linkage = load("four-bar.yaml");
  for (Joint& joint : linkage.joints)
    if (joint.first == model::ground) joint.point_first *= 100;
  CHECK(derive_conditions(linkage, {{GoalKind::force}}).status == ConditionsStatus::not_assembled);
}

TEST_CASE("the residual at fixed samples vanishes exactly where the conditions are met") {
  for (const auto& [file, goal] :
       {std::pair("5r-balanced.yaml", GoalKind::statics), std::pair("planar-rrr.yaml", GoalKind::decoupled)}) {
    const Mechanism good = load(file);
    const std::vector<Goal> goals = {{goal}};
    GoalResidual residual(good, goals);
    VectorX left;
    REQUIRE(residual.evaluate(good, left));
    CHECK(left.cwiseAbs().maxCoeff() < 1e-13);
    Mechanism bad = good;
    bad.bodies[2].com.x() += 0.01;
    REQUIRE(residual.evaluate(bad, left));
    CHECK(left.cwiseAbs().maxCoeff() > 1e-4);
  }
}
