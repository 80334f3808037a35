#include "balance/spec/subject_to.hpp"

#include "balance/base/nearest.hpp"
#include "balance/result/tracks.hpp"
#include "balance/spec/landmark.hpp"
#include "balance/spec/objective.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace balance::read {

namespace {

constexpr const char* example = "a limit such as peak(torque) <= 12 or mobility(cycloid) >= 0.1";

constexpr const char* robust_name = "mean_plus";

/// Part of a scalar's text as a scalar of its own, so that messages name its place.
class Part {
 public:
  Part(const Cursor& whole, std::size_t begin, std::size_t end) : whole_(whole), node_(whole.node()) {
    const std::string& text = whole.node().text;
    while (begin < end && is_blank(text[begin])) ++begin;
    while (end > begin && is_blank(text[end - 1])) --end;
    begin_ = begin;
    node_.text = text.substr(begin, end - begin);
    node_.place.column += begin + (node_.quoted ? 1 : 0);
  }
  Cursor cursor() const { return {node_, whole_.path(), whole_.problems()}; }
  const std::string& text() const { return node_.text; }
  /// Part of this part.
  Part part(std::size_t begin, std::size_t end) const { return {whole_, begin_ + begin, begin_ + end}; }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n'; }

  Cursor whole_;
  Node node_;
  std::size_t begin_ = 0;
};

/// Splits at a sign that stands outside all parentheses and brackets.
std::vector<Part> split(const Part& part, char sign) {
  std::vector<Part> parts;
  std::size_t begin = 0;
  int depth = 0;
  const std::string& text = part.text();
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(' || text[i] == '[') ++depth;
    if (text[i] == ')' || text[i] == ']') --depth;
    if (text[i] != sign || depth != 0) continue;
    parts.push_back(part.part(begin, i));
    begin = i + 1;
  }
  parts.push_back(part.part(begin, text.size()));
  return parts;
}

struct NamedFigureTerm {
  const char* name;
  ObjectiveTerm term;
};

const std::array<NamedFigureTerm, 11>& terms_by_name() {
  using Size = ObjectiveTerm::Size;
  using Run = ObjectiveTerm::Run;
  static const std::array<NamedFigureTerm, 11> names{{{"peak", {.figure = Figure::peak}},
                                                      {"rms", {.figure = Figure::rms}},
                                                      {"mean", {.figure = Figure::mean}},
                                                      {"range", {.figure = Figure::range}},
                                                      {"duration", {.run = Run::duration}},
                                                      {"energy", {.run = Run::energy}},
                                                      {"mobility", {.run = Run::mobility}},
                                                      {"clearance", {.run = Run::clearance}},
                                                      {"added_mass", {.size = Size::added_mass}},
                                                      {"added_inertia", {.size = Size::added_inertia}},
                                                      {"total_mass", {.size = Size::total_mass}}}};
  return names;
}

std::string unit_of(const ObjectiveTerm& term, const Mechanism& mechanism) {
  switch (term.size) {
    case ObjectiveTerm::Size::added_inertia: return "kg m^2";
    case ObjectiveTerm::Size::added_mass:
    case ObjectiveTerm::Size::total_mass: return "kg";
    case ObjectiveTerm::Size::none: break;
  }
  switch (term.run) {
    case ObjectiveTerm::Run::duration: return "s";
    case ObjectiveTerm::Run::energy: return "J";
    case ObjectiveTerm::Run::mobility: return "1";
    case ObjectiveTerm::Run::clearance: return "m";
    case ObjectiveTerm::Run::figure: break;
  }
  return figure_unit(mechanism, term.quantity);
}

class LimitReader {
 public:
  explicit LimitReader(Draft& draft) : draft_(draft) {}

  FigureLimit read(const Cursor& at) {
    const Part whole(at, 0, at.word(example).size());
    const std::size_t relation = find_relation(whole);
    FigureLimit limit;
    limit.text = whole.text();
    limit.at_least = whole.text()[relation] == '>';
    const Part left = whole.part(0, relation), right = whole.part(relation + 2, whole.text().size());
    for (const Part& part : split(left, '+')) limit.terms.push_back(read_weighted(part));
    require_alone(limit, left.cursor());
    limit.unit = common_unit_of(limit.terms);
    const double bound = draft_.parameters.evaluate(right.cursor()).value();
    limit.bound = bound * draft_.units.factor(dimension_of_unit(limit.unit));
    if (limit.unit == "1") limit.unit.clear();
    return limit;
  }

 private:
  static std::size_t find_relation(const Part& whole) {
    const std::string& text = whole.text();
    const std::size_t first = text.find_first_of("<>=");
    const bool one = first != std::string::npos && text[first] != '=' && first + 1 < text.size() &&
                     text[first + 1] == '=' && text.find_first_of("<>=", first + 2) == std::string::npos;
    if (!one) whole.cursor().fail({.expected = std::string(example) + ", with one <= or >=", .found = in_quotes(text)});
    return first;
  }

  /// `0.5 * peak(torque)`
  ObjectiveTerm read_weighted(const Part& part) {
    const std::vector<Part> factors = split(part, '*');
    ObjectiveTerm term = read_term(factors.back());
    for (std::size_t k = 0; k + 1 < factors.size(); ++k)
      term.weight *= read_weight(factors[k].cursor(), draft_.parameters);
    return term;
  }

  /// `mean_plus(3, peak(torque, cycloid))`
  ObjectiveTerm read_robust(const std::vector<Part>& given, const Part& part) {
    if (given.size() != 2)
      part.cursor().fail({.expected = "mean_plus(deviations, figure)", .found = in_quotes(part.text())});
    const double count = read_deviations(given[0].cursor(), draft_.parameters, draft_.study);
    ObjectiveTerm term = read_term(given[1]);
    if (term.size != ObjectiveTerm::Size::none || term.run != ObjectiveTerm::Run::figure || term.plus)
      given[1].cursor().fail(
          {.expected = "peak, rms, mean or range of a quantity", .found = in_quotes(given[1].text())});
    require_stated(given[1].cursor(), term, draft_.study);
    term.plus = count;
    return term;
  }

  ObjectiveTerm read_term(const Part& part) {
    const std::string& text = part.text();
    const std::size_t open = text.find('(');
    std::string name = text.substr(0, open);
    while (!name.empty() && name.back() == ' ') name.pop_back();
    std::replace(name.begin(), name.end(), '-', '_');
    std::vector<std::string> names;
    for (const NamedFigureTerm& one : terms_by_name()) names.emplace_back(one.name);
    if (name == robust_name && open != std::string::npos && text.back() == ')')
      return read_robust(split(part.part(open + 1, text.size() - 1), ','), part);
    names.emplace_back(robust_name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end() || name == robust_name)
      part.cursor().fail({.expected = fmt::format("a figure ({})", one_of(names)),
                          .found = fmt::format("{}{}", in_quotes(text),
                                               name == robust_name ? "; mean_plus(3, peak(torque)) is one"
                                                                   : nearest_hint(name, names))});
    ObjectiveTerm term = terms_by_name()[static_cast<std::size_t>(found - names.begin())].term;
    const bool size = term.size != ObjectiveTerm::Size::none;
    if (size != (open == std::string::npos) || (!size && text.back() != ')'))
      part.cursor().fail({.expected = size ? name + " without parentheses" : name + "(…)", .found = in_quotes(text)});
    if (!size) read_arguments(split(part.part(open + 1, text.size() - 1), ','), name, part.cursor(), term);
    return term;
  }

  /// What it is of, and the trajectory behind it, which may be left out.
  void read_arguments(const std::vector<Part>& given, const std::string& name, const Cursor& at, ObjectiveTerm& term) {
    using Run = ObjectiveTerm::Run;
    const std::size_t own = term.run == Run::clearance ? 2 : term.run == Run::figure ? 1 : 0;
    const bool none = own == 0 && given.size() == 1 && given[0].text().empty();
    const std::size_t count = none ? 0 : given.size();
    if (count < own || count > own + 1) {
      const char* form = own == 2   ? "(point, point or line, trajectory)"
                         : own == 1 ? "(quantity, trajectory)"
                                    : "(trajectory)";
      at.fail({.expected = name + form, .found = in_quotes(at.node().text)});
    }
    if (own == 1) term.quantity = read_quantity(given[0].cursor(), draft_.study);
    if (own == 2) {
      term.clearance.of = read_landmark(given[0].cursor(), draft_);
      for (const Part& end : ends_of_line(given[1])) term.clearance.to.push_back(read_landmark(end.cursor(), draft_));
    }
    term.trajectory = count > own ? read_along(given[own].cursor(), draft_.study) : first_along(at, draft_.study);
  }

  /// `leg2.A to leg2.B`
  static std::vector<Part> ends_of_line(const Part& part) {
    const std::size_t to = part.text().find(" to ");
    if (to == std::string::npos) return {part};
    return {part.part(0, to), part.part(to + 4, part.text().size())};
  }

  static void require_alone(const FigureLimit& limit, const Cursor& at) {
    using Run = ObjectiveTerm::Run;
    for (const ObjectiveTerm& term : limit.terms) {
      const bool least =
          term.size == ObjectiveTerm::Size::none && (term.run == Run::mobility || term.run == Run::clearance);
      if (least && (limit.terms.size() > 1 || term.weight != 1))
        at.fail({.expected = "mobility and clearance alone, not in a sum", .found = in_quotes(at.node().text)});
    }
  }

  /// Empty: they have several.
  std::string common_unit_of(const std::vector<ObjectiveTerm>& terms) const {
    const std::string unit = unit_of(terms.front(), draft_.study.mechanism);
    const bool alike = std::all_of(terms.begin(), terms.end(), [&](const ObjectiveTerm& term) {
      return unit_of(term, draft_.study.mechanism) == unit;
    });
    return alike ? unit : "";
  }

  Draft& draft_;
};

}  // namespace

std::vector<FigureLimit> read_limits(const Cursor& at, Draft& draft) {
  LimitReader reader(draft);
  if (!at.is_list()) return {reader.read(at)};
  std::vector<FigureLimit> limits;
  for (const Cursor& item : at.items("a list of limits"))
    at.problems().guard([&] { limits.push_back(reader.read(item)); });
  if (at.node().items.empty()) at.expected("at least one limit");
  return limits;
}

}  // namespace balance::read
