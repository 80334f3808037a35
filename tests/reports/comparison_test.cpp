#include "balance/interface/files/text_table.hpp"
#include "balance/interface/reports/comparison_sections.hpp"

#include <doctest/doctest.h>

#include <sstream>

namespace balance {
namespace {

/// Two runs; the second has no power. One quantity's name needs quotes in CSV.
comparison::ComparedRuns sample() {
  comparison::ComparedRuns compared;
  compared.runs = {{"original", "original.h5", "arm", "cycloid", "cycloidal", "tool", 11, 0.1, 4},
                   {"a|b", "a|b.h5", "arm", "cycloid", "cycloidal", "tool", 11, 0.1, 5}};
  const Metric force{"shaking_force", "N", 8, 0.05, 4, 2, 6}, less{"shaking_force", "N", 2, 0.07, 3, 1, 5};
  const Metric power{"power[A,1]", "W", 1, 0, 1, 1, 1};
  compared.quantities = {{"shaking_force", "N", {force, less}, {std::nullopt, comparison::Difference{7, 0.02, 3}}},
                         {"power[A,1]", "W", {power, std::nullopt}, {std::nullopt, std::nullopt}},
                         {"com_velocity", "m/s", {power, power}, {std::nullopt, comparison::Difference{}}}};
  compared.notes = {"original and a|b: something"};
  return compared;
}

std::vector<comparison::RequirementVerdict> verdicts() {
  comparison::RequirementVerdict good{
      "peak(x) <= base || 1 < 0", "a|b", true, {{"peak(x)", "base", comparison::Relation::at_most, 2, 8, "N"}}, {}};
  comparison::RequirementVerdict bad{"rms(x) < 2", "", false, {{"rms(x)", "2", comparison::Relation::less, 3, 2}}, {}};
  return {good, bad};
}

bool has(const std::string& text, const std::string& part) {
  if (text.find(part) == std::string::npos) MESSAGE(text);
  return text.find(part) != std::string::npos;
}

TEST_CASE("people see figures, ratios, differences and verdicts") {
  const std::string text = comparison_text(sample(), verdicts(), reports::QuantitySelection::main);
  CHECK(has(text, "shaking_force  N      8.00000  2.00000  0.2500\n"));
  CHECK(has(text, "power[A,1]     W      1.00000        -       -\n"));
  CHECK(has(text, "shaking_force  N     7.00000   87.5 %  3.00000\n"));
  CHECK(has(text, "energy    J      4.00000  5.00000  1.250\n"));
  CHECK(has(text, "note: original and a|b: something\n"));
  CHECK(has(text, "ok     peak(x) <= base || 1 < 0 [a|b]: holds: 2 N <= 8 N, margin 75 %\n"));
  CHECK(has(text, "FAILED rms(x) < 2: 3 is 50 % above the limit of 2\n"));
  CHECK(has(text, "\n1 of 2 requirements met\n"));
  CHECK(text.find("com_velocity") == std::string::npos);
  CHECK(has(reports::comparison_text(sample(), {}, reports::QuantitySelection::all), "com_velocity"));
}

TEST_CASE("every row of a Markdown table has as many cells as its heading") {
  std::istringstream lines(comparison_markdown(sample(), verdicts(), reports::QuantitySelection::all));
  std::size_t cells = 0;
  int tables = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("|")) {
      cells = 0;
      continue;
    }
    std::size_t count = 0;
    for (std::size_t i = 0; i < line.size(); ++i) count += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    if (cells == 0) cells = count, ++tables;
    CHECK(count == cells);
  }
  CHECK(tables == 8);  // verdicts, runs, four figures, energy, differences
}

TEST_CASE("values for programs are complete and exact") {
  const std::string csv = reports::comparison_csv(sample());
  CHECK(csv.starts_with("quantity,unit,figure,run,value,ratio\nshaking_force,N,peak,original,8,1\n"));
  CHECK(has(csv, "\nshaking_force,N,rms,a|b,3,0.75\n"));
  CHECK(has(csv, "\nshaking_force,N,largest_difference,a|b,7,\n"));
  CHECK(has(csv, "\n\"power[A,1]\",W,peak,a|b,,\n"));
  CHECK(has(csv, "\nenergy,J,total,a|b,5,1.25\n"));
  CHECK(files::escape_csv_field("say \"a\"") == "\"say \"\"a\"\"\"");
}

TEST_CASE("what is missing is null in JSON") {
  const std::string json = reports::comparison_json(sample(), verdicts());
  CHECK(has(json, "\"a|b\": null"));
  CHECK(has(json, "\"margin_percent\": -50.0"));
  CHECK(has(json, "\"all_hold\": false"));
}

TEST_CASE("a verdict is a test case: the requirement of the run") {
  const reports::JunitSuite suite = reports::make_verdict_suite("requirements", verdicts());
  REQUIRE(suite.cases.size() == 2);
  CHECK(suite.cases[0].status == reports::JunitCase::Status::passed);
  CHECK(suite.cases[0].group == "a|b");
  CHECK(suite.cases[1].status == reports::JunitCase::Status::failed);
  CHECK(suite.cases[1].group == "requirements");
  CHECK(suite.cases[1].message == "3 is 50 % above the limit of 2");
  CHECK(suite.cases[1].details == "rms(x) = 3\n2 = 2\n");
}

}  // namespace
}  // namespace balance
