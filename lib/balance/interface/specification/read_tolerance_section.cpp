#include "balance/interface/specification/read_tolerance_section.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::specification {

namespace {

/// "bodies.link1.com[0]" belongs to "bodies.link1.com", and so do all entries of an inertia's matrix.
std::string parent_path(const std::string& path) {
  const std::size_t point = path.rfind('.');
  return path.substr(0, path.find('[', point == std::string::npos ? 0 : point));
}

/// A path may be named without its section, and a component by the name of its vector.
bool is_name_of_number(const std::string& name, const std::string& path) {
  const auto short_path = [](const std::string& one) { return one.substr(one.find('.') + 1); };
  const std::string parent = parent_path(path);
  return is_glob_match(name, path) || is_glob_match(name, parent) || is_glob_match(name, short_path(path)) ||
         is_glob_match(name, short_path(parent));
}

/// Whether a number of the spec describes something that is manufactured.
bool is_manufactured(const std::string& path) {
  return !path.starts_with("controllers.") && !path.starts_with("design.");
}

/// A deviation as written.
struct ToleranceWidth {
  double size = 0;
  bool is_relative = false;  ///< relative to the number; else in the spec's units
  study::Distribution distribution = study::Distribution::normal;
};

double read_deviation(const SpecCursor& at, StudyBuilder& draft, bool& is_relative) {
  const std::string text = at.read_word("a deviation: a number, an expression or a percentage such as 1%");
  YamlNode plain = at.node();
  is_relative = text.ends_with('%');
  if (is_relative) plain.text = text.substr(0, text.size() - 1);
  const double size = draft.parameters.evaluate(SpecCursor(plain, at.path(), at.problems())).value();
  if (size < 0) at.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = quote_for_message(text)});
  return is_relative ? size / 100 : size;
}

ToleranceWidth read_width(const SpecCursor& at, StudyBuilder& draft) {
  ToleranceWidth width;
  const auto read_one = [&](const SpecCursor& c) { width.size = read_deviation(c, draft, width.is_relative); };
  if (at.is_scalar()) {
    read_one(at);
    return width;
  }
  width.distribution = study::Distribution::uniform;
  if (!read_fields(at, "a standard deviation (0.1e-3, 1%) or {uniform: half of the interval}",
                   {{"uniform", Presence::required, read_one}}))
    throw CascadingError();
  return width;
}

/// All numbers that the section may name; stores them in the recording.
std::vector<study::TolerancedParameter> list_numbers(StudyBuilder& draft) {
  std::vector<study::TolerancedParameter> toleranced;
  study::Recording& recording = *draft.recording;
  const auto add = [&](study::TolerancedParameter number, const Expression& value) {
    number.recording_index = static_cast<int>(recording.toleranced.size());
    recording.toleranced.push_back(value);
    toleranced.push_back(std::move(number));
  };
  for (const study::NamedExpression& one : recording.parameters)
    if (one.is_plain)
      add({.path = "parameters." + one.name, .value = one.value.value(), .input = recording.input_index(one.value)},
          one.value);
  for (const ToleranceEntry& one : draft.tolerance_numbers)
    add({.path = one.path,
         .value = one.value,
         .unit = one.unit,
         .input = recording.input_index(one.input),
         .is_positive = one.sign != SignConstraint::none},
        one.perturbed);
  return toleranced;
}

class ToleranceReader {
 public:
  explicit ToleranceReader(StudyBuilder& draft)
      : draft_(draft), numbers_(list_numbers(draft)), selected_by_(numbers_.size()) {}

  void read(const Member& member) {
    const std::vector<std::size_t> matches = find(member);
    const ToleranceWidth width = read_width(member.value, draft_);
    for (const std::size_t i : matches) {
      // a number's own name takes precedence over a pattern
      if (selected_by_[i] && has_wildcards(member.name) && !has_wildcards(*selected_by_[i])) continue;
      if (selected_by_[i] && has_wildcards(member.name) == has_wildcards(*selected_by_[i]))
        member.key.fail({.expected = "each number only once",
                         .found = fmt::format("{}, which {} already names", quote_for_message(numbers_[i].path),
                                              quote_for_message(*selected_by_[i]))});
      selected_by_[i] = member.name;
      set(member.value, width, numbers_[i]);
    }
  }

  Tolerances selected() const {
    Tolerances tolerances;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (selected_by_[i]) tolerances.push_back(numbers_[i]);
    return tolerances;
  }

 private:
  std::vector<std::size_t> find(const Member& member) const {
    std::vector<std::size_t> matches;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (is_name_of_number(member.name, numbers_[i].path)) matches.push_back(i);
    if (matches.empty()) {
      if (!draft_.is_mechanism_valid || draft_.problems.is_section_invalid("parameters")) throw CascadingError();
      const bool is_path = member.name.find('.') != std::string::npos;
      member.key.fail(
          {.expected =
               "a parameter with a value of its own, or the path of a number of the spec (* stands for any characters)",
           .found = quote_for_message(member.name),
           .hint = is_path ? "" : format_nearest_name(member.name, draft_.parameters.names())});
    }
    for (const std::size_t i : matches)
      if (!has_wildcards(member.name) && parent_path(numbers_[i].path) != parent_path(numbers_[matches[0]].path))
        member.key.fail(
            {.expected = "the name of one number",
             .found = fmt::format("{}, which is {} and {}", quote_for_message(member.name),
                                  quote_for_message(numbers_[matches[0]].path), quote_for_message(numbers_[i].path))});
    return matches;
  }

  static void set(const SpecCursor& at, const ToleranceWidth& width, study::TolerancedParameter& number) {
    // a percentage of a zero mass is zero, as there is no body; a percentage of a zero position is a mistake
    if (width.is_relative && number.value == 0 && !number.is_positive)
      at.fail({.expected = "a deviation in the spec's units",
               .found = fmt::format("a percentage of {}, which is zero", number.path)});
    number.width = width.is_relative ? width.size * std::abs(number.value) : width.size * number.unit;
    number.distribution = width.distribution;
    number.relative_width = width.is_relative ? width.size : 0;
    if (!std::isfinite(number.width))
      at.fail({.expected = "a number that is finite in SI units", .found = "one that is not"});
  }

  StudyBuilder& draft_;
  std::vector<study::TolerancedParameter> numbers_;
  std::vector<std::optional<std::string>> selected_by_;  ///< per number: the name that selects it
};

}  // namespace

std::set<std::string> list_tolerance_names(const SpecCursor* section) {
  std::set<std::string> names;
  if (section != nullptr)
    for (const YamlNode& key : section->node().keys) names.insert(key.text);
  return names;
}

Expression register_toleranced_parameter(const SpecCursor& at, StudyBuilder& draft, const Expression& number,
                                         Dimension dimension, SignConstraint sign) {
  const std::string& path = at.path();
  const auto is_named = [&](const std::string& name) { return is_name_of_number(name, path); };
  if (!is_manufactured(path) || std::none_of(draft.tolerance_names.begin(), draft.tolerance_names.end(), is_named))
    return number;
  for (const ToleranceEntry& existing : draft.tolerance_numbers)
    if (existing.path == path) return existing.perturbed;
  const auto load = std::find_if(draft.load_numbers.begin(), draft.load_numbers.end(),
                                 [&](const LoadParameterEntry& one) { return one.path == path && one.input; });
  const auto free = draft.inputs.find(path);
  ToleranceEntry entry{path, number.value(), draft.units.factor(dimension), sign, number, number};
  draft.number_dimensions[path] = dimension;
  if (load != draft.load_numbers.end()) {
    entry.input = *load->input;
  } else if (free != draft.inputs.end()) {
    entry.input = free->second;
  } else if (number.is_constant()) {
    entry.input = entry.perturbed = draft.add_input(number.value());
  } else {
    // the expression still follows its parameters
    entry.input = draft.add_input(0);
    entry.perturbed = number + entry.input;
  }
  draft.tolerance_numbers.push_back(entry);
  return entry.perturbed;
}

Tolerances read_tolerances(const SpecCursor& section, StudyBuilder& draft) {
  ToleranceReader reader(draft);
  for (const Member& member : list_members(section, "numbers {name: deviation}"))
    draft.problems.collect([&] { reader.read(member); });
  return reader.selected();
}

}  // namespace balance::specification
