#include "balance/interface/reports/conditions_sections.hpp"
#include "design_sample.hpp"

#include <nlohmann/json.hpp>

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::reports;

TEST_CASE("conditions stand in a table with what they miss and depend on; what no disc can miss is one line") {
  CHECK(conditions_text(sample::conditions_view()) ==
        "made up: static conditions\n"
        "at rest the actuators carry nothing\n"
        "\n"
        "rank 3 of 5 parameters, gap 14.0 decades, 17 samples\n"
        "\n"
        "no  condition             now  depends on\n"
        " 1  a.mx + l1 b.m = 0    0.12  bodies.a.com[0]\n"
        "                               counterweights.b.mass\n"
        " 2  -l1^2 a.m + e.J = 0   met  nothing free\n"
        "\n"
        "where l1 = 0.5 m\n"
        "a.m is a mass\n"
        "3 holds for every disc that is symmetrical about its axis\n"
        "1 of 3 not met: 'now' is the residual, relative to the size of the terms\n"
        "note: a note\n");
}

TEST_CASE("a spec without free numbers has no column for them, without conditions no table") {
  ConditionsReportData view = sample::conditions_view();
  view.numbers.clear();
  view.free_number_indices = {{}, {}, {}};
  CHECK(conditions_text(view).find("depends on") == std::string::npos);
  view.conditions.matrix.resize(0, 5);
  view.conditions.rank = 0;
  view.residuals.resize(0);
  view.holds_by_definition.clear();
  const std::string text = conditions_text(view);
  CHECK(text.find("no  condition") == std::string::npos);
  CHECK(text.find("no conditions: the mechanism is balanced as it is") != std::string::npos);
}

TEST_CASE("long conditions are broken between terms, never inside brackets") {
  ConditionsReportData view = sample::conditions_view();
  const conditions::RationalMonomial l{1, 1, {{0, 1}}}, one{1, 1, {}};
  for (int p = 0; p < 5; ++p) {
    view.conditions.matrix(0, p) = 1;
    view.names.formulas[0][static_cast<std::size_t>(p)] = conditions::CoefficientFormula{one, {l, one}};
  }
  const auto lines = wrap_condition(view, 0, 30);
  CHECK(lines == std::vector<std::string>{"(l1 + 1) a.m + (l1 + 1) a.mx", "    + (l1 + 1) b.m", "    + (l1 + 1) d.mx",
                                          "    + (l1 + 1) e.J = 0"});
}

TEST_CASE("numbers in a row are ranges") {
  CHECK(format_ranges({1, 2, 3, 4, 7, 9, 10}) == "1-4, 7, 9, 10");
  CHECK(format_ranges({5}) == "5");
  CHECK(format_ranges({}) == "");
}

TEST_CASE("conditions in JSON hold every coefficient, with its name where it has one") {
  const auto json = nlohmann::json::parse(files::format_json(conditions_json(sample::conditions_view(), {"odd"})));
  CHECK(json["goal"] == "static");
  CHECK(json["rank"] == 3);
  CHECK(json["gap"] == 1e14);
  CHECK(json["gap_decades"] == 14.0);
  CHECK(json["parameters"] == std::vector<std::string>{"a.m", "a.mx", "b.m", "d.mx", "e.J"});
  REQUIRE(json["conditions"].size() == 3);
  const auto& first = json["conditions"][0];
  CHECK(first["text"] == "a.mx + l1 b.m = 0");
  CHECK(first["terms"] == nlohmann::json::parse(R"([{"parameter": "a.mx", "coefficient": 1.0},
                                                    {"parameter": "b.m", "coefficient": 0.5, "name": "l1"}])"));
  CHECK(first["residual"] == 0.125);
  CHECK(first["met"] == false);
  CHECK(first["free"] == std::vector<std::string>{"bodies.a.com[0]", "counterweights.b.mass"});
  CHECK(json["conditions"][2]["by_definition"] == true);
  CHECK(json["warnings"] == std::vector<std::string>{"odd"});
  ConditionsReportData two = sample::conditions_view();
  two.conditions.goals.push_back({GoalKind::force});
  CHECK(nlohmann::json::parse(files::format_json(conditions_json(two, {})))["goal"] ==
        std::vector<std::string>{"static", "force"});
}
