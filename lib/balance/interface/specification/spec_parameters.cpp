#include "balance/interface/specification/spec_parameters.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <utility>

namespace balance::specification {

namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// A plain number; not finite if it is too large for a double or one of YAML's words for infinity or NaN.
std::optional<double> plain_number(std::string text) {
  if (text.size() == 4 || text.size() == 5) {
    const std::string word = lower_case(text);
    if (word == ".nan" || word == ".inf" || word == "+.inf" || word == "-.inf")
      return std::numeric_limits<double>::infinity();
  }
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.erase(0, 1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  // out of range: too small is zero, too large is infinite; strtod distinguishes them
  if (error == std::errc::result_out_of_range) return std::strtod(text.c_str(), nullptr);
  return value;
}

/// `deg` of `360deg`, `°` of `5 °`; empty if the text is not a number followed by something like a unit.
std::string trailing_unit(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string suffix(trim({end, text.data() + text.size()}));
  if (error == std::errc::invalid_argument || suffix.empty()) return "";
  const auto in_unit = [](char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || (static_cast<unsigned char>(c) & 0x80) != 0;
  };
  const auto in_rest = [&](char c) {
    return in_unit(c) || std::string_view("*/^23 %\"'").find(c) != std::string_view::npos;
  };
  const bool begins_unit = in_unit(suffix[0]) || suffix == "%" || suffix == "\"" || suffix == "'";
  return begins_unit && std::all_of(suffix.begin(), suffix.end(), in_rest) ? suffix : "";
}

bool is_truth_value(const std::string& text) {
  const std::string lower = lower_case(text);
  return lower == "true" || lower == "false" || lower == "yes" || lower == "no" || lower == "on" || lower == "off";
}

/// Several names joined by dots are that of a part's parameter.
bool is_identifier(const std::string& name) {
  bool at_start = true;
  for (const char c : name) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    const bool letter = c == '_' || std::isalpha(static_cast<unsigned char>(c)) != 0;
    if (at_start ? !letter : !letter && !digit && c != '.') return false;
    at_start = c == '.';
  }
  return !at_start;
}

/// Evaluates parameters after those that they depend on.
class DependencyResolver {
 public:
  DependencyResolver(const std::vector<Member>& members, SpecErrorCollector& problems,
                     std::function<void(const Member&)> evaluate)
      : members_(members), problems_(problems), evaluate_(std::move(evaluate)), state_(members.size()) {
    for (std::size_t i = 0; i < members.size(); ++i) index_[members[i].name] = i;
  }

  void run() {
    for (std::size_t i = 0; i < members_.size(); ++i) resolve(i);
  }

 private:
  enum class State { untouched, in_progress, known, failed };

  /// A parameter that depends on a failed one fails without a message of its own.
  void resolve(std::size_t i) {
    if (state_[i] == State::known || state_[i] == State::failed) return;
    if (state_[i] == State::in_progress) return report_cycle(i);
    state_[i] = State::in_progress;
    chain_.push_back(i);
    for (const std::size_t used : dependencies_of(members_[i].value.node())) {
      resolve(used);
      if (state_[used] == State::failed) state_[i] = State::failed;
    }
    chain_.pop_back();
    if (state_[i] == State::failed) return;
    state_[i] = problems_.collect([&] { evaluate_(members_[i]); }) ? State::known : State::failed;
  }

  std::vector<std::size_t> dependencies_of(const YamlNode& node) const {
    std::vector<std::size_t> used;
    if (node.kind == YamlNode::Kind::scalar)
      for (const std::string& name : expression::find_expression_names(node.text).values)
        if (const auto entry = index_.find(name); entry != index_.end()) used.push_back(entry->second);
    for (const YamlNode& item : node.items) {
      const auto nested = dependencies_of(item);
      used.insert(used.end(), nested.begin(), nested.end());
    }
    return used;
  }

  void report_cycle(std::size_t repeated) {
    const auto start = std::find(chain_.begin(), chain_.end(), repeated);
    constexpr std::ptrdiff_t max_listed_cycle = 12;
    std::string cycle;
    for (auto i = start; i != chain_.end(); ++i) {
      if (i - start < max_listed_cycle) cycle += members_[*i].name + " → ";
      if (i - start == max_listed_cycle) cycle += "… → ";
      state_[*i] = State::failed;
    }
    problems_.collect([&] {
      members_[repeated].value.fail({.expected = "a parameter that does not depend on itself",
                                     .found = "the cycle " + cycle + members_[repeated].name});
    });
  }

  const std::vector<Member>& members_;
  SpecErrorCollector& problems_;
  std::function<void(const Member&)> evaluate_;
  std::map<std::string, std::size_t> index_;
  std::vector<State> state_;
  std::vector<std::size_t> chain_;
};

}  // namespace

SpecParameters::SpecParameters(const std::optional<SpecCursor>& section, const Overrides& overrides,
                               std::set<std::string> zero_start_parameters, study::Recording& recording,
                               SpecErrorCollector& problems)
    : added_element_parameters_(std::move(zero_start_parameters)) {
  std::vector<Member> members;
  if (section) problems.collect([&] { members = list_members(*section, "a mapping of parameters"); });
  for (const Member& member : members) names_.push_back(member.name);
  name_set_ = {names_.begin(), names_.end()};

  std::erase_if(members, [&](const Member& member) {
    const auto& functions = expression::function_names();
    const bool is_reserved =
        member.name == "pi" || std::find(functions.begin(), functions.end(), member.name) != functions.end();
    return !problems.collect([&] {
      const auto fail = [&](const char* expected, const std::string& found) {
        ReadError error(
            member.key.node().place, member.key.path(),
            {.expected = expected, .found = found, .hint = find_decimal_comma_before(section->node(), member.name)});
        error.unknown_key_in = "parameters";
        throw ReadError(std::move(error));
      };
      if (!is_identifier(member.name)) fail("a name of letters, digits and '_'", quote_for_message(member.name));
      if (is_reserved) fail("an unused name", quote_for_message(member.name) + ", which has a meaning in expressions");
    });
  });

  override_values(overrides, members, problems);
  DependencyResolver(members, problems, [&](const Member& member) { define(member, recording); }).run();
  const auto position = [&](const study::NamedExpression& one) {
    return std::find(names_.begin(), names_.end(), one.name);
  };
  std::sort(
      recording.parameters.begin(), recording.parameters.end(),
      [&](const study::NamedExpression& a, const study::NamedExpression& b) { return position(a) < position(b); });
}

/// The text of an override takes the place of the parameter's own value.
void SpecParameters::override_values(const Overrides& overrides, std::vector<Member>& members,
                                     SpecErrorCollector& problems) {
  for (const auto& [name, text] : overrides) {
    const bool is_known = std::find(names_.begin(), names_.end(), name) != names_.end();
    if (!is_known && !(names_.empty() && problems.is_section_invalid("parameters")))
      problems.add(
          {{},
           "--set " + name,
           {.expected = fmt::format("a parameter ({})", names_.empty() ? "there are none" : join_alternatives(names_)),
            .found = quote_for_message(name),
            .hint = format_nearest_name(name, names_)}});
    YamlNode& node = replacements_[name];
    node.kind = YamlNode::Kind::scalar;
    node.text = text;
  }
  for (Member& member : members) {
    const auto replacement = replacements_.find(member.name);
    if (replacement == replacements_.end()) continue;
    overridden_.emplace_back(&member.value.node(), replacement->second.text);
    member.value = SpecCursor(replacement->second, "--set " + member.name, problems);
  }
}

void SpecParameters::define(const Member& member, study::Recording& recording) {
  const auto add_input = [&](double value) {
    recording.inputs.push_back(value);
    return Expression::input(recording.graph, value);
  };
  Expression value;
  bool is_plain = true;
  if (!member.value.is_map()) {
    value = evaluate(member.value);
    is_plain = expression::find_expression_names(member.value.node().text).values.empty();
    value = is_plain ? add_input(value.value()) : Expression::make_alias(recording.graph, value);
  } else {
    FreeValue free = evaluate_free(member.value);
    if (added_element_parameters_.contains(member.name)) free.default_start_to_zero();
    value = add_input(free.start);
    free_numbers_.push_back({&member.value.node(),
                             {.key_path = member.value.path(),
                              .lower = free.lower,
                              .upper = free.upper,
                              .start = free.start,
                              .start_source = free.start_source,
                              .discrete_values = free.discrete_values},
                             value});
  }
  values_[member.name] = value;
  recording.parameters.push_back({member.name, value, is_plain});
}

Expression SpecParameters::evaluate(const SpecCursor& scalar) {
  const std::string what = "a number, an expression or {free: [lower, upper]}";
  const std::string text(trim(scalar.read_word(what)));
  // most numbers are plain, and most others a single parameter
  if (const auto known = values_.find(text); known != values_.end()) return known->second;
  if (name_set_.count(text) > 0) throw CascadingError();
  const std::optional<double> number = plain_number(text);
  if (!number && (text.empty() || is_truth_value(text))) scalar.fail_expected(what);
  const auto parameter = [&](const std::string& name) { return values_.at(name); };
  const Expression value = number ? Expression(*number) : evaluate_expression(scalar, text, {}, parameter);
  if (!std::isfinite(value.value())) scalar.fail({.expected = "a finite number", .found = quote_for_message(text)});
  return value;
}

Expression SpecParameters::evaluate(
    const SpecCursor& scalar, const std::vector<std::string>& variables,
    const std::function<Expression(const std::string& name, const Expression* parameter)>& value) {
  const std::string text(trim(scalar.read_word("a number or an expression")));
  return evaluate_expression(scalar, text, variables, [&](const std::string& name) {
    const auto parameter = values_.find(name);
    return value(name, parameter == values_.end() ? nullptr : &parameter->second);
  });
}

/// Whether the parameter of this name may be one with an invalid name, or in a section that was not read.
bool SpecParameters::can_be_invalid(const SpecCursor& at, const std::string& name) const {
  return at.problems().is_section_invalid("parameters." + name) ||
         (names_.empty() && at.problems().is_section_invalid("parameters"));
}

Expression SpecParameters::evaluate_expression(const SpecCursor& scalar, const std::string& text,
                                               const std::vector<std::string>& variables,
                                               const std::function<Expression(const std::string& name)>& value) {
  const auto fail = [&](const std::string& reason) {
    scalar.fail(
        {.message = fmt::format("expected a number or an expression, found {}: {}", quote_for_message(text), reason),
         .expected = "a number or an expression",
         .found = quote_for_message(text),
         .hint = reason});
  };
  if (const std::string comma = suggest_decimal_point(text); !comma.empty()) fail(comma);
  const std::string unit = trailing_unit(text);
  if (!unit.empty() && name_set_.count(unit) == 0)
    fail(fmt::format("{} cannot follow a number: 'units:' sets the units of all numbers", quote_for_message(unit)));
  const auto fail_unknown = [&](const char* what, const std::string& name, const std::vector<std::string>& candidates) {
    fail(fmt::format("there is no {} {}{}", what, quote_for_message(name), append_nearest_name(name, candidates)));
  };
  expressions_size_ += text.size();
  if (expressions_size_ > max_expressions_length)
    scalar.fail({.expected = fmt::format("at most {} characters in all expressions together", max_expressions_length)});
  const auto& functions = expression::function_names();
  const expression::ExpressionNames used = expression::find_expression_names(text);
  for (const std::string& name : used.functions)
    if (std::find(functions.begin(), functions.end(), name) == functions.end())
      fail_unknown("function", name, functions);
  for (const std::string& name : used.values) {
    const bool is_function = std::find(functions.begin(), functions.end(), name) != functions.end();
    if (is_function) fail(fmt::format("the function {} needs parentheses: {}(…)", quote_for_message(name), name));
    const bool is_parameter = name_set_.count(name) > 0;
    if (!is_parameter && std::find(variables.begin(), variables.end(), name) != variables.end()) continue;
    if (is_parameter ? values_.count(name) == 0 : can_be_invalid(scalar, name)) throw CascadingError();
    if (is_parameter) continue;
    std::vector<std::string> candidates = names_;
    candidates.insert(candidates.end(), variables.begin(), variables.end());
    fail_unknown(variables.empty() ? "parameter" : "parameter or variable", name, candidates);
  }
  try {
    return expression::parse_expression(text, value);
  } catch (const expression::ExpressionError& error) {
    fail(error.what());
    throw;
  }
}

FreeValue SpecParameters::evaluate_free(const SpecCursor& map, const std::vector<Field>& others) {
  return read_free_value(
      map, [this](const SpecCursor& c) { return evaluate(c).value(); }, others);
}

}  // namespace balance::specification
