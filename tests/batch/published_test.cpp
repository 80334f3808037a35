// Cases with printed numbers, without a motion, and with solved parameters, as the suite states them.

#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/batch_summary.hpp"
#include "balance/interface/batch/published_row.hpp"
#include "balance/interface/batch/suite.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace {

using namespace balance;
using namespace balance::batch;

constexpr double pi = std::numbers::pi;

Suite suite_of(const std::string& text) { return parse_suite(text, "suite.yaml"); }

std::string message(const std::string& text) {
  try {
    suite_of(text);
  } catch (const SpecError& error) {
    std::string all;
    for (const Diagnostic& one : error.diagnostics()) all += one.place.text() + ": " + one.message + "\n";
    return all;
  }
  return "no error";
}

bool says(const std::string& text, const std::string& part) {
  const std::string said = message(text);
  if (said.find(part) == std::string::npos) MESSAGE(said);
  return said.find(part) != std::string::npos;
}

std::string row(const std::string& fields) {
  return "cases: {K15-2: {spec: s, published: [{what: piston speed, unit: m/s, " + fields + "}]}}";
}

const std::string speed = R"-(figure: "-value(joint_velocity[X], joint_position[A] = pi/3)")-";

CaseRecord record_with(const std::string& name, const std::string& figure, double value) {
  CaseRecord record;
  record.name = name;
  record.status = "done";
  comparison::EvaluatedFigure evaluated;
  evaluated.text = figure;
  evaluated.value = value;
  evaluated.unit = "m/s";
  record.figures.push_back(evaluated);
  return record;
}

}  // namespace

TEST_CASE("half of the last digit is that of the number as written") {
  const std::pair<const char*, double> halves[] = {{"6.90536", 5e-6}, {"6.833", 5e-4}, {"121", 0.5},    {"1.2e3", 50},
                                                   {"-0.50", 5e-3},   {"3e-4", 5e-5},  {"2.50E+2", 0.5}};
  for (const auto& [text, half] : halves) CHECK(balance::batch::half_last_digit(text) == half);
}

TEST_CASE("a row is judged with the tolerance of its exact number") {
  const Suite suite = suite_of(row("printed: 6.833, exact: 6.90536, verdict: drawn, note: by hand, " + speed));
  const PublishedRow& published = suite.cases.at(0).published.at(0);
  CHECK(published.tolerance == 5e-6);
  CHECK(published.verdict == PublishedVerdict::drawn);
  const std::string figure = published.figure.figures.at(0).text();
  const auto summary = [&](double value) { return summarise_batch(suite, {record_with("K15-2", figure, value)}); };
  for (const double held : {-6.90536, -6.905364999, -6.905355001}) CHECK(summary(held).exit_code() == 0);
  for (const double missed : {-6.91, -6.90537, 6.90536}) CHECK(summary(missed).exit_code() == 1);
  CHECK(format_failures(summary(-6.91)) == "FAILED K15-2: piston speed: 6.91 m/s, expected 6.90536 ± 5e-06 m/s\n");
  // the digits show that it differs
  CHECK(format_failures(summary(-6.905366)) ==
        "FAILED K15-2: piston speed: 6.905366 m/s, expected 6.90536 ± 5e-06 m/s\n");
  const std::string json = summary_json(summary(-6.90536));
  CHECK(json.find("\"verdict\": \"drawn\"") != std::string::npos);
  CHECK(json.find("\"printed\": 6.833") != std::string::npos);
  CHECK(json.find("\"holds\": true") != std::string::npos);
  const std::string markdown = summary_markdown(summary(-6.90536));
  CHECK(markdown.find("| K15-2 | piston speed [m/s] | 6.833 | 6.90536 | 6.90536 | +1.1 % | drawn | yes |") !=
        std::string::npos);
  CHECK(summary_junit(summary(-6.91)).find("name=\"K15-2: piston speed\"") != std::string::npos);
}

TEST_CASE("a proof compares figures, and a case's rows have names of their own") {
  const std::string improved = "printed: 2, exact: 1, verdict: improved, figure: 'peak(torque)', proof: ";
  CHECK(message(row(improved + "1 < 2")).find("proof: expected a requirement such as") != std::string::npos);
  CHECK(suite_of(row(improved + "'verdict() == proved-best'")).cases.at(0).published.at(0).proof);
  const std::string twice = "{what: w, printed: 2, verdict: reproduced, figure: 'peak(torque)'}";
  CHECK(message("cases: {a: {spec: s, published: [" + twice + ", " + twice + "]}}")
            .find("published[1]: two published numbers of one case are called 'w'") != std::string::npos);
}

TEST_CASE("units of rows convert to SI") {
  const std::pair<const char*, double> units[] = {
      {"deg", pi / 180}, {"N mm", 1e-3},        {"rad/s^2", 1},
      {"kg m^2", 1},     {"deg/s", pi / 180},   {"in/s^2", 0.0254},
      {"%", 0.01},       {"turn/min", pi / 30}, {"lbf in", 0.0254 * 4.4482216152605}};
  for (const auto& [unit, value] : units) {
    const Suite suite = suite_of("cases: {a: {spec: s, published: [{what: w, unit: '" + std::string(unit) +
                                 "', printed: 2, verdict: reproduced, figure: 'peak(torque[A])'}]}}");
    CHECK_MESSAGE(suite.cases.at(0).published.at(0).unit_value.value == doctest::Approx(value).epsilon(1e-14), unit);
  }
  CHECK(
      says("cases: {a: {spec: s, published: [{what: w, unit: m/sec, printed: 2, verdict: reproduced, figure: "
           "'peak(torque)'}]}}",
           "suite.yaml:1:50: cases.a.published[0].unit: expected a unit such as m/s"));
}

TEST_CASE("a verdict that contradicts the numbers is a mistake at its place") {
  CHECK(message(row("printed: 6.91, exact: 6.9054, verdict: reproduced, " + speed)) == "no error");
  CHECK(says(row("printed: 6.833, exact: 6.90536, verdict: reproduced, " + speed),
             "the verdict is reproduced, but the printed number 6.833 differs from the exact one, 6.90536, by more "
             "than half of its last digit, 0.0005"));
  CHECK(says(row("printed: 6.833, verdict: misprint, " + speed),
             "cases.K15-2.published[0].verdict: the verdict is misprint, but the exact number is the printed one"));
  CHECK(says(row("printed: 6.833, exact: 6.5, verdict: improved, " + speed),
             "the verdict is improved, which needs a "
             "proof"));
  CHECK(message(row("printed: 6.833, exact: 6.5, verdict: improved, proof: verdict() == proved-best, " + speed)) ==
        "no error");
  CHECK(says(row("printed: 6.833, verdict: reprodused, " + speed), "nearest is 'reproduced'"));
  CHECK(says(row("printed: 6.8.3, verdict: reproduced, " + speed), "expected a number as printed"));
  CHECK(says(row("printed: 6.8, verdict: reproduced, figure: 'value(joint_velocity[X], 0.1) < 3'"),
             "column 31: expected arithmetic without comparisons, found '<'"));
  CHECK(says(row("printed: 6.8, verdict: reproduced, figure: 'valu(joint_velocity[X], 0.1)'"), "nearest is 'value'"));
  CHECK(says(row("printed: 6.8, verdict: reproduced, figure: 'verdict()'"), "verdict() is a word, not a number"));
}

TEST_CASE("an improvement without its proof does not hold") {
  const Suite suite = suite_of(
      "cases: {a: {spec: s, run: design, require: verdict() == proved-best, published: [{what: added mass, unit: kg, "
      "printed: 0.443, exact: 0.355, verdict: improved, figure: added_mass()}]}}");
  const auto outcome = [&](const std::string& word) {
    CaseRecord record = record_with("a", "added_mass()", 0.3551);
    record.figures.front().unit = "kg";
    balance::comparison::EvaluatedFigure verdict;
    verdict.text = "verdict()";
    verdict.word = word;
    record.figures.push_back(verdict);
    return summarise_batch(suite, {record});
  };
  CHECK(outcome("balanced proved-best").exit_code() == 0);
  const BatchSummary missed = outcome("balanced local-best");
  CHECK(missed.exit_code() == 1);
  CHECK(missed.requirements.at(0).message == "the verdict is balanced local-best, not proved-best");
  CHECK(missed.requirements.at(1).message ==
        "the proof does not hold: verdict() == proved-best: the verdict is balanced local-best, not proved-best");
}

TEST_CASE("a requirement on the verdict makes an impossible design a result") {
  const Suite suite =
      suite_of("cases: {a: {spec: s, run: design, require: verdict() == impossible}, b: {spec: s, run: design}}");
  CHECK(asks_for_verdict(suite, suite.cases.at(0)));
  CHECK_FALSE(asks_for_verdict(suite, suite.cases.at(1)));
  CaseRecord record = record_with("a", "added_mass()", 1);
  record.status = "compromise";
  record.message = "the design is not balanced";
  record.design = {"impossible", "why", 1, 1, 1};
  CHECK(accept_verdict(record, true).exit_code() == 0);
  CHECK(accept_verdict(record, true).message.empty());
  record.status = "mechanism";
  CHECK(accept_verdict(record, true).exit_code() == 0);
  CHECK(accept_verdict(record, false).exit_code() == 4);  // it was to be run, too
  CHECK(says("cases: {a: {spec: s, run: design, require: verdict() == proved-bets}}",
             "column 14: expected a verdict (balanced, compromise, impossible, not-found, not-asked, unsolved, "
             "proved-best, local-best or stopped), found 'proved-bets'; nearest is 'proved-best'"));
  CHECK(says("cases: {a: {spec: s, run: design, require: verdict() < impossible}}",
             "verdict() is compared with one word"));
  CHECK(message("cases: {a: {spec: s, run: design, require: verdict() != impossible && bound() > 1}}") == "no error");
}

TEST_CASE("keys of cases without a motion, their points and solved parameters") {
  const Suite suite = suite_of(R"-(
defaults: {spec: s, points: {D: rod.D}}
cases:
  a: {run: equations, at: {J1: 0.3, J2: pi/2}, rates: {J1: 1}, require: "torque[J1] == 2 && inertia[J1, J2] < 3"}
  b: {run: equations, at: {tool: [0.1, 0.2]}, points: {E: {rod: [0.1, -pi/4]}}}
  c: {solve: {N: {figure: "value(torque[Z], 0)", equals: 0, within: [100, 300]
}
}
}
)-");
  CHECK(suite.cases[0].state.at == "J1=0.3,J2=pi/2");
  CHECK(suite.cases[0].state.rates == "J1=1");
  CHECK(suite.cases[1].state.at == "{tool: [0.1, 0.2]}");
  REQUIRE(suite.cases[1].points.size() == 2);
  CHECK(suite.cases[1].points[0].body == "rod");
  CHECK(suite.cases[1].points[0].body_point == "D");
  CHECK(suite.cases[1].points[1].position == std::vector<double>{0.1, -pi / 4});
  CHECK(suite.cases[2].solved.at(0).upper == 300);
  CHECK(says("cases: {a: {spec: s, run: equation}}", "nearest is 'equations'"));
  CHECK(says("cases: {a: {spec: s, run: equations}}", "'run: equations' needs 'at'"));
  CHECK(says("cases: {a: {spec: s, run: design, controller: c}}", "has no motion and so no 'controller'"));
  CHECK(says("cases: {a: {spec: s, set: {N: 1}, solve: {N: {figure: duration(), equals: 0, within: [1, 2]}}}}",
             "'set' and 'solve' both give the parameter 'N'"));
  CHECK(says("cases: {a: {spec: s, solve: {N: {figure: duration(), equals: 0, within: [2, 1]}}}}", "lower < upper"));
  CHECK(says("cases: {a: {spec: s, solve: {N: {figure: 3, equals: 0, within: [1, 2]}}}}",
             "expected arithmetic of "
             "figures"));
  CHECK(says("cases: {a: {spec: s, require: 'torque[J1] < 2'}}", "torque is a quantity"));
  CHECK(says("cases: {a: {spec: s, points: {D: {rod: [1]}}}}", "expected a point's coordinates [x, y] or [x, y, z]"));
}

TEST_CASE("a record answers what was asked of it, and a new requirement asks more") {
  const Suite first = suite_of("cases: {a: {spec: s, require: 'value(joint_velocity[X], 0.1) < 3'}}");
  const Suite second =
      suite_of("cases: {a: {spec: s, require: ['value(joint_velocity[X], 0.1) < 4', duration() > 0]}}");
  const auto asked = list_asked_figures(first).at(0);
  REQUIRE(asked.size() == 1);
  const CaseRecord record = record_with("a", "value(joint_velocity[X], 0.1)", 1);
  CHECK(record.answers(asked));
  CHECK_FALSE(record.answers(list_asked_figures(second).at(0)));
  const auto read = decode_record(encode_record(record));
  REQUIRE(read);
  CHECK(read->answers(asked));
  CHECK(encode_record(*read) == encode_record(record));
}

TEST_CASE("figures are asked of the cases that they are judged for, and of those that they name") {
  const Suite suite = suite_of(
      "cases: {a: {spec: s}, b: {spec: s, require: 'duration() > 0'}, c: {spec: s}}\nbaseline: a\n"
      "require: ['value(torque[A], 0.1) <= base', 'maximum(torque[A], c) < 3']");
  const auto asked = list_asked_figures(suite);
  const auto texts = [&](std::size_t i) {
    std::string all;
    for (const balance::comparison::FigureReference& figure : asked[i]) all += figure.text() + ";";
    return all;
  };
  CHECK(texts(0) == "value(torque[A], 0.1);");
  CHECK(texts(1) == "value(torque[A], 0.1);duration();");
  CHECK(texts(2) == "value(torque[A], 0.1);maximum(torque[A]);");
}
