#include "balance/spec/tolerances.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace balance::read {

namespace {

bool has_stars(const std::string& name) { return name.find('*') != std::string::npos; }

/// Whether a name with stars, each for any characters, is the whole of a text. Steps at most once per star and character.
bool fits(std::string_view name, std::string_view text) {
  std::size_t n = 0, t = 0, star = std::string_view::npos, taken = 0;
  while (t < text.size()) {
    if (n < name.size() && name[n] == '*') {
      star = n++;
      taken = t;
    } else if (n < name.size() && name[n] == text[t]) {
      ++n, ++t;
    } else if (star != std::string_view::npos) {
      n = star + 1;
      t = ++taken;
    } else {
      return false;
    }
  }
  while (n < name.size() && name[n] == '*') ++n;
  return n == name.size();
}

/// "bodies.link1.com[0]" belongs to "bodies.link1.com", and so do all entries of an inertia's matrix.
std::string whole_of(const std::string& path) {
  const std::size_t point = path.rfind('.');
  return path.substr(0, path.find('[', point == std::string::npos ? 0 : point));
}

/// A path may be called without its section, and a component by the name of its vector.
bool names_number(const std::string& name, const std::string& path) {
  const auto short_path = [](const std::string& one) { return one.substr(one.find('.') + 1); };
  const std::string whole = whole_of(path);
  return fits(name, path) || fits(name, whole) || fits(name, short_path(path)) || fits(name, short_path(whole));
}

/// What of a spec is not made.
bool is_made(const std::string& path) { return !path.starts_with("controllers.") && !path.starts_with("design."); }

/// How far off, as written.
struct Width {
  double size = 0;
  bool part = false;  ///< of the number's size; else in the spec's units
  Spread spread = Spread::normal;
};

double read_deviation(const Cursor& at, Draft& draft, bool& part) {
  const std::string text = at.word("a deviation: a number, an expression or a percentage such as 1%");
  Node plain = at.node();
  part = text.ends_with('%');
  if (part) plain.text = text.substr(0, text.size() - 1);
  const double size = draft.parameters.evaluate(Cursor(plain, at.path(), at.problems())).value();
  if (size < 0) at.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = in_quotes(text)});
  return part ? size / 100 : size;
}

Width read_width(const Cursor& at, Draft& draft) {
  Width width;
  const auto read_one = [&](const Cursor& c) { width.size = read_deviation(c, draft, width.part); };
  if (at.is_scalar()) {
    read_one(at);
    return width;
  }
  width.spread = Spread::uniform;
  if (!read_fields(at, "a standard deviation (0.1e-3, 1%) or {uniform: half of the interval}",
                   {{"uniform", Need::required, read_one}}))
    throw Consequence();
  return width;
}

/// Every number that a name of the section may call; the recording gets what they are.
std::vector<ToleranceNumber> list_numbers(Draft& draft) {
  std::vector<ToleranceNumber> all;
  Recording& recording = *draft.recording;
  const auto add = [&](ToleranceNumber number, const Expression& value) {
    number.number = static_cast<int>(recording.toleranced.size());
    recording.toleranced.push_back(value);
    all.push_back(std::move(number));
  };
  for (const NamedExpression& one : recording.parameters)
    if (one.plain)
      add({.path = "parameters." + one.name, .value = one.value.value(), .input = recording.input_of(one.value)},
          one.value);
  for (const FoundTolerance& one : draft.tolerance_numbers)
    add({.path = one.path,
         .value = one.value,
         .unit = one.unit,
         .input = recording.input_of(one.input),
         .positive = one.sign != Sign::any},
        one.moved);
  return all;
}

class ToleranceReader {
 public:
  explicit ToleranceReader(Draft& draft) : draft_(draft), numbers_(list_numbers(draft)), by_(numbers_.size()) {}

  void read(const Member& member) {
    const std::vector<std::size_t> found = find(member);
    const Width width = read_width(member.value, draft_);
    for (const std::size_t i : found) {
      // What is called by its own name is no longer meant by one with stars.
      if (by_[i] && has_stars(member.name) && !has_stars(*by_[i])) continue;
      if (by_[i] && has_stars(member.name) == has_stars(*by_[i]))
        member.key.fail(
            {.expected = "every number once",
             .found = fmt::format("{}, which {} calls already", in_quotes(numbers_[i].path), in_quotes(*by_[i]))});
      by_[i] = member.name;
      set(member.value, width, numbers_[i]);
    }
  }

  Tolerances chosen() const {
    Tolerances all;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (by_[i]) all.push_back(numbers_[i]);
    return all;
  }

 private:
  std::vector<std::size_t> find(const Member& member) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (names_number(member.name, numbers_[i].path)) found.push_back(i);
    if (found.empty()) {
      if (!draft_.mechanism_is_right || draft_.problems.lost("parameters")) throw Consequence();
      const bool path = member.name.find('.') != std::string::npos;
      member.key.fail(
          {.expected =
               "a parameter with a value of its own, or the path of a number of the spec (* stands for any characters)",
           .found = in_quotes(member.name),
           .hint = path ? "" : nearest_is(member.name, draft_.parameters.names())});
    }
    for (const std::size_t i : found)
      if (!has_stars(member.name) && whole_of(numbers_[i].path) != whole_of(numbers_[found[0]].path))
        member.key.fail({.expected = "the name of one number",
                         .found = fmt::format("{}, which is {} and {}", in_quotes(member.name),
                                              in_quotes(numbers_[found[0]].path), in_quotes(numbers_[i].path))});
    return found;
  }

  static void set(const Cursor& at, const Width& width, ToleranceNumber& number) {
    // A mass of zero is no body, and a part of it none; a place of zero is one as any other.
    if (width.part && number.value == 0 && !number.positive)
      at.fail({.expected = "a deviation in the spec's units",
               .found = fmt::format("a percentage of {}, which is zero", number.path)});
    number.width = width.part ? width.size * std::abs(number.value) : width.size * number.unit;
    number.spread = width.spread;
    number.part = width.part ? width.size : 0;
    if (!std::isfinite(number.width))
      at.fail({.expected = "a number that is finite in SI units", .found = "one that is not"});
  }

  Draft& draft_;
  std::vector<ToleranceNumber> numbers_;
  std::vector<std::optional<std::string>> by_;  ///< per number: the name that calls it
};

}  // namespace

std::set<std::string> list_tolerance_names(const Cursor* section) {
  std::set<std::string> names;
  if (section != nullptr)
    for (const Node& key : section->node().keys) names.insert(key.text);
  return names;
}

Expression as_toleranced(const Cursor& at, Draft& draft, const Expression& number, double unit, Sign sign) {
  const std::string& path = at.path();
  const auto is = [&](const std::string& name) { return names_number(name, path); };
  if (!is_made(path) || std::none_of(draft.tolerance_names.begin(), draft.tolerance_names.end(), is)) return number;
  for (const FoundTolerance& known : draft.tolerance_numbers)
    if (known.path == path) return known.moved;
  const auto load = std::find_if(draft.load_numbers.begin(), draft.load_numbers.end(),
                                 [&](const FoundLoad& one) { return one.path == path && one.input; });
  const auto free = draft.inputs.find(path);
  FoundTolerance found{path, number.value(), unit, sign, number, number};
  if (load != draft.load_numbers.end()) {
    found.input = *load->input;
  } else if (free != draft.inputs.end()) {
    found.input = free->second;
  } else if (number.is_constant()) {
    found.input = found.moved = draft.add_input(number.value());
  } else {
    // The expression goes on following its parameters.
    found.input = draft.add_input(0);
    found.moved = number + found.input;
  }
  draft.tolerance_numbers.push_back(found);
  return found.moved;
}

Tolerances read_tolerances(const Cursor& section, Draft& draft) {
  ToleranceReader reader(draft);
  for (const Member& member : members(section, "numbers {name: deviation}"))
    draft.problems.guard([&] { reader.read(member); });
  return reader.chosen();
}

}  // namespace balance::read
