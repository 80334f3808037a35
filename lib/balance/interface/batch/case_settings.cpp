#include "balance/interface/batch/case_settings.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/expression/expression_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace balance::batch {

using specification::SpecCursor;

namespace {

const std::vector<std::string> kind_names{"motion", "design", "conditions", "equations", "modes"};

/// A number or arithmetic of numbers.
double read_constant(const SpecCursor& at, const std::string& expectation) {
  const std::string& text = at.read_word(expectation);
  const auto no_name = [](const std::string& name) -> Expression {
    throw expression::ExpressionError("unknown name " + quote_for_message(name));
  };
  try {
    const double value = expression::parse_expression(text, no_name).value();
    if (std::isfinite(value)) return value;
  } catch (const expression::ExpressionError& error) {
    at.fail({.expected = expectation, .found = quote_for_message(text), .hint = error.what()});
  }
  at.fail_expected(expectation);
}

/// `J1=0.3,J2=0.5`. @param member one entry of a mapping from joint coordinates to values
std::string format_assignment(const specification::Member& member) {
  const std::string& value = member.value.read_word("a joint coordinate's value, a number or an expression");
  if (value.find(',') != std::string::npos) member.value.fail_expected("one value");
  return member.name + "=" + value;
}

std::string read_assignments(const SpecCursor& at, const std::string& expectation) {
  std::string text;
  for (const specification::Member& member : list_named_members(at, expectation))
    text += (text.empty() ? "" : ",") + format_assignment(member);
  if (text.empty()) at.fail_expected(expectation);
  return text;
}

}  // namespace

CaseKind read_case_kind(const SpecCursor& at) {
  return static_cast<CaseKind>(at.read_choice("what the case computes", kind_names));
}

std::string read_state_pose(const SpecCursor& at) {
  const std::string expectation = "a pose: {J1: 0.3, J2: 0.5}, {tool: [0.1, 0.2]}, start or end";
  if (at.is_scalar()) return at.read_word(expectation);
  if (!at.is_map() || at.node().items.empty()) at.fail_expected(expectation);
  constexpr std::array pose_keys{"tool", "joints", "com", "angle", "rpy", "quaternion"};
  const bool is_pose =
      std::any_of(pose_keys.begin(), pose_keys.end(), [&](const char* key) { return at.has_entry(key); });
  return is_pose ? format_flow(at.node()) : read_assignments(at, expectation);
}

std::string read_state_rates(const SpecCursor& at) {
  const std::string expectation = "a mapping from joint coordinates to values, {J1: 1, J2: -2}";
  return at.is_scalar() ? at.read_word(expectation) : read_assignments(at, expectation);
}

void read_case_points(const SpecCursor& at, SuiteCase& suite_case, const RecordLocation& record) {
  const std::string expectation = "points {name: body.point} or {name: {body: [x, y]}}";
  for (const specification::Member& member : list_named_members(at, expectation, specification::NameForm::simple)) {
    CasePoint point;
    point.name = member.name;
    if (member.value.is_map()) {
      const std::vector<specification::Member> bodies = list_named_members(member.value, "a point {body: [x, y]}");
      if (bodies.size() != 1) member.value.fail_expected("a point of one body, {body: [x, y]}");
      point.body = bodies.front().name;
      const std::string place = "a point's coordinates [x, y] or [x, y, z]";
      for (const SpecCursor& item : bodies.front().value.items(place))
        point.position.push_back(read_constant(item, "a coordinate"));
      if (point.position.size() < 2 || point.position.size() > 3) bodies.front().value.fail_expected(place);
    } else {
      const std::string& text = member.value.read_word("a point of a body, body.point");
      const std::size_t dot = text.rfind('.');
      point.body = text.substr(0, dot);
      if (dot != std::string::npos) point.body_point = text.substr(dot + 1);
    }
    std::erase_if(suite_case.points, [&](const CasePoint& one) { return one.name == point.name; });
    suite_case.points.push_back(std::move(point));
    record("points." + member.name, member.value);
  }
}

void read_solved_parameters(const SpecCursor& at, SuiteCase& suite_case, const RecordLocation& record) {
  for (const specification::Member& member :
       list_named_members(at, "solved parameters {name: {figure, equals, within}}")) {
    SolvedParameter solved;
    solved.parameter = member.name;
    const auto read_solved_figure = [&](const SpecCursor& c) {
      solved.figure = read_figure(c, {{}, "", true}, "arithmetic of figures such as 'value(torque[Z], 0)'");
    };
    const auto read_bracket = [&](const SpecCursor& c) {
      const std::vector<SpecCursor> items = c.items("the bracket of the parameter, [lower, upper]", 2);
      solved.lower = read_constant(items[0], "the parameter's lower bound, a number");
      solved.upper = read_constant(items[1], "the parameter's upper bound, a number");
      if (!(solved.lower < solved.upper)) c.fail_expected("a bracket [lower, upper] with lower < upper");
    };
    if (!specification::read_fields(
            member.value, "a solved parameter {figure, equals, within}",
            {{"figure", specification::Presence::required, read_solved_figure},
             {"equals", specification::Presence::required,
              [&](const SpecCursor& c) { solved.value = read_constant(c, "the figure's value, a number"); }},
             {"within", specification::Presence::required, read_bracket}}))
      throw specification::CascadingError();
    std::erase_if(suite_case.solved, [&](const SolvedParameter& one) { return one.parameter == solved.parameter; });
    suite_case.solved.push_back(std::move(solved));
    record("solve." + member.name, member.value);
  }
}

void check_case(const SpecCursor& at, const SuiteCase& suite_case) {
  const std::string kind = "run: " + kind_names[static_cast<std::size_t>(suite_case.kind)];
  const auto fail_unless = [&](bool is_valid, const std::string& message) {
    if (!is_valid) at.fail({.message = message, .expected = "keys that belong together", .found = kind});
  };
  if (suite_case.kind == CaseKind::equations)
    fail_unless(!suite_case.state.at.empty(), "'run: equations' needs 'at': a pose such as {J1: 0.3} or start");
  for (const SolvedParameter& solved : suite_case.solved)
    for (const auto& [name, value] : suite_case.overrides)
      fail_unless(name != solved.parameter,
                  fmt::format("'set' and 'solve' both give the parameter {}", quote_for_message(name)));
  fail_unless(suite_case.kind == CaseKind::motion || suite_case.controller.empty(),
              fmt::format("'{}' has no motion and so no 'controller'", kind));
}

void check_case_keys(const SpecCursor& at, CaseKind kind) {
  using enum CaseKind;
  const std::pair<const char*, std::vector<CaseKind>> kinds_of_keys[]{{"at", {equations}},
                                                                      {"rates", {equations}},
                                                                      {"accelerations", {equations}},
                                                                      {"goal", {conditions}},
                                                                      {"sweep", {modes}},
                                                                      {"trajectory", {motion, equations, modes}},
                                                                      {"samples", {motion, equations}}};
  for (const auto& [key, kinds] : kinds_of_keys) {
    if (!at.has_entry(key) || std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) continue;
    std::vector<std::string> uses;
    for (const CaseKind one : kinds) uses.push_back("run: " + kind_names[static_cast<std::size_t>(one)]);
    const std::string found = "run: " + kind_names[static_cast<std::size_t>(kind)];
    at.fail({.message = fmt::format("'{}' is for {}, not for '{}'", key, join_alternatives(uses), found),
             .expected = "keys that belong together",
             .found = found});
  }
}

}  // namespace balance::batch
