#include "balance/interface/comparison/requirement.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace balance {
namespace {

Metric metric(const std::string& quantity, double peak, double rms) {
  return {quantity, quantity.starts_with("torque") ? "N m" : "N", peak, 0, rms, rms / 2, 2 * peak};
}

/// Three runs; `rail-2` has no torque[A2], the first two no cart_force.
std::vector<comparison::MetricTable> runs() {
  return {
      {"original",
       {metric("shaking_force", 800, 400), metric("torque[A1]", 100, 50), metric("torque[A2]", 60, 30)},
       10},
      {"bang", {metric("shaking_force", 500, 300), metric("torque[A1]", 130, 55), metric("torque[A2]", 90, 20)}, 12},
      {"rail-2", {metric("shaking_force", 720, 410), metric("torque[A1]", 90, 45)}, 8}};
}

comparison::RunNames names() { return {{"original", "bang", "rail-2"}, "original"}; }

std::vector<comparison::RequirementVerdict> judged(const std::string& text) {
  return judge_each_run(parse_requirement(text, names()), runs());
}

bool holds(const std::string& text) {
  const std::vector<comparison::RequirementVerdict> verdicts = judged(text);
  REQUIRE(verdicts.size() == 1);
  return verdicts.front().holds;
}

std::string message(const std::string& text) {
  try {
    check_quantities(parse_requirement(text, names()), list_quantity_names(runs()));
  } catch (const comparison::RequirementError& error) {
    return error.what();
  }
  return "no error";
}

bool says(const std::string& text, const std::string& part) {
  const std::string said = message(text);
  if (said.find(part) == std::string::npos) MESSAGE(text, ": ", said);
  return said.find(part) != std::string::npos;
}

TEST_CASE("a requirement without names is judged for every run but the base") {
  const std::vector<comparison::RequirementVerdict> verdicts = judged("peak(shaking_force) <= 0.9 * base");
  REQUIRE(verdicts.size() == 2);
  CHECK(verdicts[0].run == "bang");
  CHECK(verdicts[0].holds);
  CHECK(verdicts[0].compared.at(0).left == 500);
  CHECK(verdicts[0].compared.at(0).right == 720);
  CHECK(verdicts[0].compared.at(0).margin() == 220);
  CHECK(verdicts[0].compared.at(0).margin_percent() == doctest::Approx(100 * 220. / 720).epsilon(1e-14));
  CHECK(verdicts[1].run == "rail-2");
  CHECK(verdicts[1].holds);  // 720 <= 720
  CHECK(verdicts[1].compared.at(0).margin() == 0);
  CHECK_FALSE(judged("peak(shaking_force) < 0.9 * base")[1].holds);
}

TEST_CASE("a requirement that names all its runs is judged once") {
  CHECK(holds("peak(shaking_force, bang) < 0.7 * peak(shaking_force, base)"));
  CHECK(judged("peak(shaking_force, bang) < 1")[0].run.empty());
  CHECK(holds("1 < 2"));
  CHECK_FALSE(holds("energy(bang) <= energy(base)"));
}

TEST_CASE("a run's name alone is the first figure of the comparison, of that run") {
  CHECK(holds("rms(torque[A1], bang) == 1.1 * base"));
  CHECK(holds("mean(shaking_force, bang) == 0.75 * original"));
  CHECK(holds("energy(bang) == base + 2"));
  CHECK(holds("base == peak(shaking_force, bang) + 300"));
  // behind && the figure is that of its own comparison
  CHECK(holds("peak(shaking_force, bang) < base && rms(torque[A1], bang) > base"));
}

TEST_CASE("every figure of a quantity can be asked for") {
  CHECK(holds("peak(torque[A1], bang) == 130"));
  CHECK(holds("rms(torque[A1], bang) == 55"));
  CHECK(holds("mean(torque[A1], bang) == 27.5"));
  CHECK(holds("range(torque[A1], bang) == 260"));
}

TEST_CASE("names with signs in them are names where there is a run of that name") {
  CHECK(holds("peak(torque[A1], bang) > rail-2"));
  CHECK(holds("peak(torque[A1], bang) - 'rail-2' == 40"));
  CHECK(holds("peak(torque[A1], \"rail-2\") == 90"));
  CHECK(holds("peak( torque[A1] ,rail-2 )==90"));
}

TEST_CASE("names that are numbers stand in quotes") {
  const std::vector<comparison::MetricTable> tables{{"1", {metric("shaking_force", 7, 1)}, 0},
                                                    {"2", {metric("shaking_force", 9, 1)}, 0}};
  const comparison::RunNames both{{"1", "2"}, "1"};
  CHECK(judge_each_run(parse_requirement("peak(shaking_force) == 2 * '1' - 5", both), tables).at(0).holds);
  CHECK(judge_each_run(parse_requirement("peak(shaking_force, 2) == 9", both), tables).at(0).holds);
}

TEST_CASE("arithmetic and logic bind as usual") {
  CHECK(holds("2 + 3 * 2 ^ 2 == 14"));
  CHECK(holds("-(1 - 3) / 4 == 0.5"));
  CHECK(holds("max(1, 2e-1, sqrt(16)) == 4"));
  CHECK(holds("1 < 0 && 1 < 0 || 1 < 2"));
  CHECK(holds("1 < 2 || 1 < 0 && 1 < 0"));
  CHECK_FALSE(holds("(1 < 2 || 1 < 0) && 1 < 0"));
  CHECK(holds("((1 + 1) * 2 > 3) && (1) < (2)"));
}

TEST_CASE("every comparison means what it says") {
  for (const double left : {1., 2., 3.}) {
    const std::string text = std::to_string(left);
    CHECK(holds(text + " < 2") == (left < 2));
    CHECK(holds(text + " <= 2") == (left <= 2));
    CHECK(holds(text + " > 2") == (left > 2));
    CHECK(holds(text + " >= 2") == (left >= 2));
    CHECK(holds(text + " == 2") == (left == 2));
  }
  CHECK(holds("1 == 1 + 1e-10"));
  CHECK_FALSE(holds("1 == 1 + 1e-8"));
}

TEST_CASE("what a run does not have never holds, whatever is made of it") {
  for (const char* text : {"peak(torque[A2], rail-2) < 1e9", "peak(torque[A2], rail-2) >= 0",
                           "min(peak(torque[A2], rail-2), 1) <= 1", "0 * peak(torque[A2], rail-2) == 0"}) {
    INFO(text);
    const std::vector<comparison::RequirementVerdict> verdicts = judged(text);
    CHECK_FALSE(verdicts.at(0).holds);
    CHECK(verdicts.at(0).missing == std::vector<std::string>{"rail-2 has no torque[A2]"});
    CHECK(describe_verdict(verdicts.at(0)) == "rail-2 has no torque[A2]");
  }
  CHECK(holds("peak(torque[A2], rail-2) < 1 || energy(rail-2) < 9"));
  std::vector<comparison::MetricTable> broken = runs();
  broken[1].metrics[0].peak = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(judge_each_run(parse_requirement("peak(shaking_force, bang) < 1e9", names()), broken).at(0).holds);
}

TEST_CASE("a verdict says by how much") {
  CHECK(describe_verdict(judged("peak(torque[A1]) <= 1.2 * base")[0]) ==
        "130 N m is 8.33 % above the limit of 120 N m");
  CHECK(describe_verdict(judged("peak(shaking_force) <= base")[0]) == "holds: 500 N <= 800 N, margin 37.5 %");
  CHECK(describe_verdict(judged("peak(torque[A1]) >= base")[0]) == "holds: 130 N m >= 100 N m, margin 30 %");
  CHECK(describe_verdict(judged("energy(bang) < 0")[0]) == "12 J is 12 J above the limit of 0 J");
  // of several that fail, the one that misses by most
  CHECK(describe_verdict(judged("peak(torque[A1]) <= base && peak(torque[A2]) <= base")[0]) ==
        "90 N m is 50 % above the limit of 60 N m");
  CHECK(describe_verdict(judged("peak(shaking_force) >= base")[0]) == "500 N is 37.5 % below the limit of 800 N");
  CHECK(describe_verdict(judged("peak(shaking_force, base) < 800")[0]) == "800 N is not below the limit of 800 N");
  CHECK(describe_verdict(judged("peak(shaking_force) == base")[0]) == "500 N is 37.5 % from 800 N");
}

TEST_CASE("a comparison has a unit where both sides are numbers of it") {
  for (const char* text :
       {"peak(shaking_force) <= 0.9 * base", "7 <= peak(shaking_force) - 3", "-mean(shaking_force) < 1",
        "max(peak(shaking_force), rms(shaking_force, base)) <= base + 1"})
    CHECK_MESSAGE(judged(text)[0].compared.at(0).unit == "N", text);
  for (const char* text :
       {"peak(shaking_force) / rms(shaking_force) < 2", "peak(torque[A1]) <= 0.3 * peak(shaking_force)",
        "peak(shaking_force)^2 < 9", "sqrt(peak(shaking_force)) < 9", "1 < 2"})
    CHECK_MESSAGE(judged(text)[0].compared.at(0).unit.empty(), text);
  CHECK(judged("energy() < 2")[0].compared.at(0).unit == "J");
}

TEST_CASE("mistakes are found with their place and the nearest name") {
  CHECK(says("peak(shaking_force) <= 0,9 * base", "use a decimal point: 0.9"));
  CHECK(
      says("peak(shakin_force) <= base", "column 6: no run has a quantity 'shakin_force'; nearest is 'shaking_force'"));
  CHECK(says("peak(torque[A3]) <= base", "column 6: no run has a quantity 'torque[A3]'; nearest is 'torque[A"));
  CHECK(says("peak(shaking_force) <= bas",
             "column 24: no run is called 'bas': original, bang, rail-2 or base; nearest is 'base'"));
  CHECK(says("peak(shaking_force, bong) <= 1", "column 21: no run is called 'bong'"));
  CHECK(says("peek(shaking_force) <= 1",
             "column 1: 'peek' is not a function: peak, rms, mean, range, minimum, maximum, order, forward_order, "
             "backward_order, fluctuation, energy, value"));
  CHECK(says("peek(shaking_force) <= 1", "or arithmetic; nearest is 'peak'"));
  CHECK(
      says("peak(shaking_force)", "column 1: expected a comparison (<, <=, >, >= or ==), found 'peak(shaking_force)'"));
  CHECK(says("", "column 1: expected a comparison"));
  CHECK(says("1 < 2 < 3", "column 7: a comparison has two sides"));
  CHECK(says("1 < ", "column 5: expected a number or a figure, found the end"));
  CHECK(says("< 1", "column 1: expected a number or a figure, found '<'"));
  CHECK(says("1 2 < 3", "column 3: expected an operator, found '2'"));
  CHECK(says("2 * / 3 < 3", "column 5: expected a number or a figure, found '/'"));
  CHECK(says("(1 < 2", "column 1: the parenthesis is not closed"));
  CHECK(says("1) < 2", "column 2: this parenthesis closes nothing"));
  CHECK(says("1 + (1 < 2) < 3", "column 8: a comparison cannot be part of arithmetic"));
  CHECK(says("1 = 1", "column 3: '=' is not a comparison"));
  CHECK(says("1 != 1", "column 3: '!=' is not a comparison"));
  CHECK(says("1 < 2 ? 1 : 0", "column 7: '?' does not belong in a requirement"));
  CHECK(says("peak(shaking_force < 1", "expected ')'"));
  CHECK(says("peak() < 1", "column 6: expected a quantity"));
  CHECK(says("peak(torque[A1) < 1", "column 12: the bracket is not closed"));
  CHECK(says("peak(shaking_force, ) < 1", "column 21: expected the name of a run"));
  CHECK(says("1 < base", "column 5: 'base' alone stands for the comparison's figure"));
  CHECK(says("1 < 'bang", "column 5: the quote is not closed"));
  CHECK(says("torque[A1] < 1", "column 1: torque is a quantity: peak(torque[…]), value(torque[…], end)"));
  CHECK(says("atan2(1) < 1", "column 1: 'atan2(1)': "));
  CHECK(says("1 < 2 &&", "column 9: expected a comparison, found the end"));
  CHECK(says("&& 1 < 2", "column 1: expected a comparison, found '&&'"));
  CHECK(says("1, 2 < 3", "column 1: '1, 2': it has more than one value"));
  CHECK(says("1.2.3 < 2", "column 1: "));
  CHECK(says("2x < 2", "column 1: no run is called '2x'"));
  CHECK(says(std::string(2000, '1') + " < 2", "it is longer than"));
}

TEST_CASE("mistakes in the arguments of figures are found with their place") {
  CHECK(says("value(torque[A1], ) < 1", "column 19: expected a time in s, start, end, a condition such as"));
  CHECK(says("value(torque[A1], bong) < 1", "or the name of a run (original, bang, rail-2 or base), found 'bong'"));
  CHECK(says("value(torque[A1], torque[A2] == 3) < 1", "column 30: a condition has a single '='"));
  CHECK(says("value(torque[A1], torque[A2] = x) < 1", "column 31: expected a number after '=', found 'x'"));
  CHECK(says("value(torque[A1], torque[A2] = 3 #0) < 1", "column 34: expected the number of a crossing from 1"));
  CHECK(says("value(torque[A1], bang, 0.3, rail-2) < 1", "column 30: value has two runs"));
  CHECK(says("value(torque[A1], 0.3, between) < 1", "column 24: no run is called 'between'"));
  CHECK(says("value(torque[A1], 0.3, 0.4) < 1", "column 24: no run is called '0.4'"));
  CHECK(says("value(torque[A1], peak(torque) 3) < 1", "column 32: expected ',' or ')'"));
  CHECK(says("value(torque[A1], end", "column 6: the parenthesis is not closed"));
  CHECK(says("duration(3) < 1", "column 10: no run is called '3'"));
  CHECK(says("time() < 1", "column 6: expected a time in s"));
  CHECK(says("number() < 1", "column 8: expected the path of a number"));
  CHECK(says("verdict() < proved-best", "verdict() is compared with one word"));
  CHECK(says("verdict() == best", "column 14: expected a verdict (balanced, "));
  CHECK(says("2 * verdict() == proved-best", "verdict() is compared with one word"));
}

TEST_CASE("one figure has one text, however it is written") {
  const auto text_of = [](const std::string& figure) {
    return list_figures(parse_requirement(figure + " < 1", names())).at(0).text();
  };
  const std::string text = "value(torque[A1], joint_position[A] = 0.5 #2, before)";
  CHECK(text_of("value(torque[A1], joint_position[A] = 0.5 #2, before)") == text);
  CHECK(text_of("value( torque[A1],joint_position[A]=1/2#2 , before, bang)") == text);
  CHECK(text_of("value(torque[A1], 'rail-2', joint_position[A] = 0.5 # 2, before)") == text);
  CHECK(text_of("value(torque[A1], 3/10)") == "value(torque[A1], 0.3)");
  CHECK(text_of("value(torque[A1], peak( shaking_force[x] ))") == "value(torque[A1], peak(shaking_force[x]))");
  CHECK(text_of("time(end)") == "time(end)");
  CHECK(text_of("duration(base)") == "duration()");
  CHECK(text_of("number(counterweights.cw.mass, bang)") == "number(counterweights.cw.mass)");
}

TEST_CASE("no text breaks the reader") {
  const std::string whole =
      "(peak(torque[A1], 'rail-2') <= 0.9e-1 * base - sqrt(2)) && rms(shaking_force)==1||energy(base)>pi"
      "&&value(torque[A1].x, torque[A2] = pi/2 #2, before, bang) < time(peak(torque[A1])) || verdict() != proved-best";
  for (std::size_t length = 0; length <= whole.size(); ++length) message(whole.substr(0, length));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const char c : std::string("()[]'<=&|,.-e1 \xff")) {
      std::string changed = whole;
      changed[i] = c;
      message(changed);
    }
  }
  CHECK(message(whole) == "no error");
}

TEST_CASE("without a base there is no base") {
  const comparison::RunNames alone{{"original", "bang"}, ""};
  CHECK_THROWS_AS(parse_requirement("energy() <= base", alone), comparison::RequirementError);
  CHECK_NOTHROW(parse_requirement("energy() <= 12", alone));
}

TEST_CASE("the runs that a requirement names are known before there are figures") {
  const comparison::Requirement requirement =
      parse_requirement("peak(shaking_force) <= min(0.9 * base, energy('rail-2'))", names());
  CHECK(requirement.named_runs() == std::vector<std::string>{"original", "rail-2"});
  CHECK(requirement.applies_to_each_run());
}

}  // namespace
}  // namespace balance
