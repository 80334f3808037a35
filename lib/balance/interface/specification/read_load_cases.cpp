#include "balance/interface/specification/read_load_cases.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/part_insertion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::specification {

namespace {

constexpr Eigen::Index max_load_cases = 64;
constexpr long default_range_samples = 5;

/// "payloads.cargo.mass" may also be named "cargo.mass".
std::string without_section(const std::string& path) { return path.substr(path.find('.') + 1); }

bool is_name_of(const std::string& name, const std::string& path) {
  return name == path || name == without_section(path);
}

/// The same, or the name of what contains it: "cw1.at" for "counterweights.cw1.at[0]".
bool is_name_of_container(const std::string& name, const std::string& path) {
  const auto is_container = [&](const std::string& whole) {
    return whole.starts_with(name) &&
           (whole.size() == name.size() || whole[name.size()] == '.' || whole[name.size()] == '[');
  };
  return is_container(path) || is_container(without_section(path));
}

/// The number that a name under `for` stands for, and how to read its values.
struct NamedLoad {
  study::LoadParameter number;
  SignConstraint sign = SignConstraint::none;
};

[[noreturn]] void fail_at(const SpecCursor& key, const std::string& found, const std::string& hint = "") {
  key.fail(
      {.expected = "a parameter with a value of its own, or the path of a number of the mechanism that is not free",
       .found = found,
       .hint = hint});
}

std::optional<NamedLoad> find_parameter(const Member& member, const StudyBuilder& draft) {
  const auto has_name = [&](const study::NamedExpression& one) {
    return is_name_of(member.name, "parameters." + one.name);
  };
  const auto& parameters = draft.recording->parameters;
  const auto parameter = std::find_if(parameters.begin(), parameters.end(), has_name);
  if (parameter == parameters.end()) return std::nullopt;
  const std::string path = "parameters." + parameter->name;
  const auto& free = draft.parameters.free_numbers();
  if (std::any_of(free.begin(), free.end(), [&](const FreeNumberEntry& one) { return one.number.key_path == path; }))
    fail_at(member.key, quote_for_message(member.name) + ", which is free");
  if (!parameter->is_plain) fail_at(member.key, quote_for_message(member.name) + ", which depends on other parameters");
  return NamedLoad{{member.name, path, parameter->value.value(), 1, draft.recording->input_index(parameter->value)},
                   SignConstraint::none};
}

NamedLoad find_named_load(const Member& member, const StudyBuilder& draft) {
  if (const auto parameter = find_parameter(member, draft)) return *parameter;
  std::vector<const LoadParameterEntry*> matches;
  for (const LoadParameterEntry& one : draft.load_numbers)
    if (is_name_of(member.name, one.path)) matches.push_back(&one);
  if (matches.empty() && !draft.is_mechanism_valid) throw CascadingError();
  if (matches.empty())
    fail_at(member.key, quote_for_message(member.name), format_nearest_name(member.name, draft.parameters.names()));
  if (matches.size() > 1)
    fail_at(member.key, quote_for_message(member.name) + ", which is " + quote_for_message(matches[0]->path) + " and " +
                            quote_for_message(matches[1]->path));
  if (!matches[0]->input) fail_at(member.key, quote_for_message(member.name) + ", which is free");
  const LoadParameterEntry& load = *matches.front();
  return {{member.name, load.path, load.input->value(), load.unit, draft.recording->input_index(*load.input)},
          load.sign};
}

double read_value(const SpecCursor& at, StudyBuilder& draft, const NamedLoad& load) {
  if (!at.is_scalar()) at.fail_expected("a number or an expression");
  const double value = draft.parameters.evaluate(at).value();
  if (load.sign == SignConstraint::positive && !(value > 0))
    at.fail({.kind = "must be positive", .expected = "a number > 0", .found = fmt::format("{}", value)});
  if (load.sign != SignConstraint::none && value < 0)
    at.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = fmt::format("{}", value)});
  const double number = value * load.number.unit;
  if (!std::isfinite(number)) at.fail({.expected = "a number that is finite in SI units", .found = "one that is not"});
  return number;
}

VectorX read_range(const SpecCursor& at, StudyBuilder& draft, const NamedLoad& load) {
  std::vector<double> bounds;
  long samples = default_range_samples;
  const bool is_valid =
      read_fields(at, "values [a, b, …] or {range: [from, to], samples: n}",
                  {{"range", Presence::required,
                    [&](const SpecCursor& c) {
                      read_each(c.items("[from, to]", 2),
                                [&](const SpecCursor& end) { bounds.push_back(read_value(end, draft, load)); });
                      if (!(bounds[0] < bounds[1]))
                        c.fail({.expected = "from < to", .found = fmt::format("[{}, {}]", bounds[0], bounds[1])});
                    }},
                   {"samples", Presence::optional,
                    [&](const SpecCursor& c) { samples = read_integer(c, draft, 2, max_load_cases); }}});
  if (!is_valid) throw CascadingError();
  return VectorX::LinSpaced(samples, bounds[0], bounds[1]);
}

VectorX read_values(const SpecCursor& at, StudyBuilder& draft, const NamedLoad& load) {
  if (at.is_map()) return read_range(at, draft, load);
  std::vector<double> values;
  read_each(at.items("values [a, b, …] or {range: [from, to], samples: n}"), [&](const SpecCursor& item) {
    const double value = read_value(item, draft, load);
    if (std::find(values.begin(), values.end(), value) != values.end())
      item.fail({.expected = "each value only once", .found = item.describe_found() + " again"});
    values.push_back(value);
  });
  if (values.empty()) at.fail_expected("at least one value");
  return Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void require_new(const Member& member, const NamedLoad& load, const std::vector<study::LoadParameter>& existing) {
  for (const study::LoadParameter& one : existing)
    if (one.path == load.number.path) fail_at(member.key, quote_for_message(member.name) + ", which is already listed");
}

/// All combinations; the last number changes first.
void read_product(const SpecCursor& at, StudyBuilder& draft, study::LoadCases& cases) {
  std::vector<VectorX> lists;
  Eigen::Index count = 1;
  bool is_valid = true;
  for (const Member& member : list_members(at, "numbers {name: values}")) {
    is_valid = draft.problems.collect([&] {
      const NamedLoad load = find_named_load(member, draft);
      require_new(member, load, cases.numbers);
      lists.push_back(read_values(member.value, draft, load));
      count = std::min(count * lists.back().size(), max_load_cases + 1);
      cases.numbers.push_back(load.number);
    }) && is_valid;
  }
  if (!is_valid) throw CascadingError();
  if (count < 2 || count > max_load_cases)
    at.fail({.expected = fmt::format("2 to {} cases", max_load_cases),
             .found = count > max_load_cases ? "more" : fmt::format("{}", lists.empty() ? 0 : count)});
  cases.values.resize(count, static_cast<Eigen::Index>(lists.size()));
  for (Eigen::Index row = 0; row < count; ++row) {
    Eigen::Index quotient = row;
    for (Eigen::Index k = cases.values.cols() - 1; k >= 0; --k) {
      const VectorX& list = lists[static_cast<std::size_t>(k)];
      cases.values(row, k) = list[quotient % list.size()];
      quotient /= list.size();
    }
  }
}

/// One mapping per case, all with the same names.
void read_listed(const SpecCursor& at, StudyBuilder& draft, study::LoadCases& cases) {
  const std::vector<SpecCursor> items = at.items("cases {name: value}");
  const auto count = static_cast<Eigen::Index>(items.size());
  if (count < 2 || count > max_load_cases)
    at.fail({.expected = fmt::format("2 to {} cases", max_load_cases), .found = fmt::format("{}", count)});
  std::vector<NamedLoad> loads;
  Eigen::Index row = 0;
  read_each(items, [&](const SpecCursor& item) {
    const std::vector<Member> members = list_members(item, "a case {name: value}");
    if (loads.empty()) {
      for (const Member& member : members) {
        loads.push_back(find_named_load(member, draft));
        require_new(member, loads.back(), cases.numbers);
        cases.numbers.push_back(loads.back().number);
      }
      if (members.empty()) item.fail_expected("at least one number {name: value}");
      cases.values.resize(count, static_cast<Eigen::Index>(loads.size()));
    }
    std::vector<std::string> names;
    for (const NamedLoad& load : loads) names.push_back(load.number.name);
    if (members.size() != loads.size()) item.fail_expected("a value for each of " + join_alternatives(names));
    for (const Member& member : members) {
      const auto match = std::find(names.begin(), names.end(), member.name);
      if (match == names.end()) fail_expected_one_of(member.key, "a number of the first case", names);
      const auto column = match - names.begin();
      cases.values(row, column) = read_value(member.value, draft, loads[static_cast<std::size_t>(column)]);
    }
    ++row;
  });
}

}  // namespace

std::set<std::string> list_load_names(const SpecCursor* design) {
  std::set<std::string> names;
  const YamlNode* loads = design == nullptr ? nullptr : find_entry(design->node(), "for");
  if (loads == nullptr) return names;
  const auto collect = [&](const YamlNode& map) {
    for (const YamlNode& key : map.keys) names.insert(key.text);
  };
  collect(*loads);
  for (const YamlNode& item : loads->items) collect(item);
  return names;
}

Expression register_load_parameter(const SpecCursor& at, StudyBuilder& draft, const Expression& number,
                                   Dimension dimension, SignConstraint sign) {
  const auto is_named = [&](const std::string& name) { return is_name_of(name, at.path()); };
  if (std::none_of(draft.load_names.begin(), draft.load_names.end(), is_named)) return number;
  for (const LoadParameterEntry& entry : draft.load_numbers)
    if (entry.path == at.path() && entry.input) return *entry.input;
  const Expression input = draft.add_input(number.value());
  draft.load_numbers.push_back({at.path(), draft.units.factor(dimension), sign, input});
  draft.number_dimensions[at.path()] = dimension;
  return input;
}

void register_free_load_name(const std::string& path, StudyBuilder& draft) {
  if (!draft.load_names.empty()) draft.load_numbers.push_back({path, 1, SignConstraint::none, std::nullopt});
}

void read_load_cases(const SpecCursor& at, StudyBuilder& draft, study::LoadCases& cases) {
  if (at.is_list())
    read_listed(at, draft, cases);
  else
    read_product(at, draft, cases);
}

study::CaseAggregation read_case_aggregation(const SpecCursor& at) {
  return at.read_choice("a way to combine the cases", {"worst", "mean"}) == 0 ? study::CaseAggregation::worst
                                                                              : study::CaseAggregation::mean;
}

std::set<std::string> read_adapted(const SpecCursor& at, const StudyBuilder& draft) {
  std::vector<std::string> free;
  for (const auto* all : {&draft.parameters.free_numbers(), &draft.free_numbers})
    for (const FreeNumberEntry& one : *all) free.push_back(one.number.key_path);
  std::set<std::string> paths;
  if (free.empty()) return paths;  // a designed spec: its free numbers have become plain numbers
  const auto read_name = [&](const SpecCursor& item) {
    const std::string& name = item.read_word("the name of a free number, or of something that contains some");
    bool is_known = false;
    for (const std::string& path : free) {
      if (!is_name_of_container(name, path)) continue;
      paths.insert(path);
      is_known = true;
    }
    if (is_known) return;
    if (!draft.is_mechanism_valid) throw CascadingError();
    fail_expected_one_of(item, "a free number, or something that contains some", free);
  };
  if (!at.is_list()) {
    read_name(at);
    return paths;
  }
  read_each(at.items("names of free numbers"), read_name);
  if (paths.empty()) at.fail_expected("at least one name");
  return paths;
}

}  // namespace balance::specification
