#include "balance/spec/subject_to.hpp"

#include "balance/base/nearest.hpp"
#include "balance/result/tracks.hpp"
#include "balance/spec/landmark.hpp"
#include "balance/spec/objective.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace balance::specification {

namespace {

constexpr const char* limit_example = "a limit such as peak(torque) <= 12 or mobility(cycloid) >= 0.1";

constexpr const char* robust_function_name = "mean_plus";

/// Part of a scalar's text as a scalar of its own, so that messages name its place.
class TextPart {
 public:
  TextPart(const SpecCursor& whole, std::size_t begin, std::size_t end) : whole_(whole), node_(whole.node()) {
    const std::string& text = whole.node().text;
    while (begin < end && is_blank(text[begin])) ++begin;
    while (end > begin && is_blank(text[end - 1])) --end;
    begin_ = begin;
    node_.text = text.substr(begin, end - begin);
    node_.place.column += begin + (node_.is_quoted ? 1 : 0);
  }
  SpecCursor cursor() const { return {node_, whole_.path(), whole_.problems()}; }
  const std::string& text() const { return node_.text; }
  /// Part of this part.
  TextPart part(std::size_t begin, std::size_t end) const { return {whole_, begin_ + begin, begin_ + end}; }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n'; }

  SpecCursor whole_;
  YamlNode node_;
  std::size_t begin_ = 0;
};

/// Splits at a sign that stands outside all parentheses and brackets.
std::vector<TextPart> split_outside_brackets(const TextPart& part, char sign) {
  std::vector<TextPart> parts;
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
  using Run = ObjectiveTerm::RunMeasure;
  static const std::array<NamedFigureTerm, 11> names{{{"peak", {.figure = Statistic::peak}},
                                                      {"rms", {.figure = Statistic::rms}},
                                                      {"mean", {.figure = Statistic::mean}},
                                                      {"range", {.figure = Statistic::range}},
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
    case ObjectiveTerm::RunMeasure::duration: return "s";
    case ObjectiveTerm::RunMeasure::energy: return "J";
    case ObjectiveTerm::RunMeasure::mobility: return "1";
    case ObjectiveTerm::RunMeasure::clearance: return "m";
    case ObjectiveTerm::RunMeasure::figure: break;
  }
  return find_metric_unit(mechanism, term.quantity);
}

class LimitReader {
 public:
  explicit LimitReader(StudyBuilder& draft) : draft_(draft) {}

  FigureLimit read(const SpecCursor& at) {
    const TextPart whole(at, 0, at.read_word(limit_example).size());
    const std::size_t relation = find_relation(whole);
    FigureLimit limit;
    limit.text = whole.text();
    limit.is_lower = whole.text()[relation] == '>';
    const TextPart left = whole.part(0, relation), right = whole.part(relation + 2, whole.text().size());
    for (const TextPart& part : split_outside_brackets(left, '+')) limit.terms.push_back(read_weighted(part));
    require_alone(limit, left.cursor());
    limit.unit = common_unit_of(limit.terms);
    const double bound = draft_.parameters.evaluate(right.cursor()).value();
    limit.bound = bound * draft_.units.factor(dimension_of_unit(limit.unit));
    if (limit.unit == "1") limit.unit.clear();
    return limit;
  }

 private:
  static std::size_t find_relation(const TextPart& whole) {
    const std::string& text = whole.text();
    const std::size_t first = text.find_first_of("<>=");
    const bool one = first != std::string::npos && text[first] != '=' && first + 1 < text.size() &&
                     text[first + 1] == '=' && text.find_first_of("<>=", first + 2) == std::string::npos;
    if (!one)
      whole.cursor().fail(
          {.expected = std::string(limit_example) + ", with one <= or >=", .found = quote_for_message(text)});
    return first;
  }

  /// `0.5 * peak(torque)`
  ObjectiveTerm read_weighted(const TextPart& part) {
    const std::vector<TextPart> factors = split_outside_brackets(part, '*');
    ObjectiveTerm term = read_term(factors.back());
    for (std::size_t k = 0; k + 1 < factors.size(); ++k)
      term.weight *= read_weight(factors[k].cursor(), draft_.parameters);
    return term;
  }

  /// `mean_plus(3, peak(torque, cycloid))`
  ObjectiveTerm read_robust(const std::vector<TextPart>& given, const TextPart& part) {
    if (given.size() != 2)
      part.cursor().fail({.expected = "mean_plus(deviations, figure)", .found = quote_for_message(part.text())});
    const double count = read_deviation_multiple(given[0].cursor(), draft_.parameters, draft_.study);
    ObjectiveTerm term = read_term(given[1]);
    if (term.size != ObjectiveTerm::Size::none || term.run != ObjectiveTerm::RunMeasure::figure ||
        term.deviation_multiple)
      given[1].cursor().fail(
          {.expected = "peak, rms, mean or range of a quantity", .found = quote_for_message(given[1].text())});
    require_prescribed_motion(given[1].cursor(), term, draft_.study);
    term.deviation_multiple = count;
    return term;
  }

  ObjectiveTerm read_term(const TextPart& part) {
    const std::string& text = part.text();
    const std::size_t open = text.find('(');
    std::string name = text.substr(0, open);
    while (!name.empty() && name.back() == ' ') name.pop_back();
    std::replace(name.begin(), name.end(), '-', '_');
    std::vector<std::string> names;
    for (const NamedFigureTerm& one : terms_by_name()) names.emplace_back(one.name);
    if (name == robust_function_name && open != std::string::npos && text.back() == ')')
      return read_robust(split_outside_brackets(part.part(open + 1, text.size() - 1), ','), part);
    names.emplace_back(robust_function_name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end() || name == robust_function_name)
      part.cursor().fail({.expected = fmt::format("a figure ({})", join_alternatives(names)),
                          .found = fmt::format("{}{}", quote_for_message(text),
                                               name == robust_function_name ? "; mean_plus(3, peak(torque)) is one"
                                                                            : append_nearest_name(name, names))});
    ObjectiveTerm term = terms_by_name()[static_cast<std::size_t>(found - names.begin())].term;
    const bool size = term.size != ObjectiveTerm::Size::none;
    if (size != (open == std::string::npos) || (!size && text.back() != ')'))
      part.cursor().fail(
          {.expected = size ? name + " without parentheses" : name + "(…)", .found = quote_for_message(text)});
    if (!size)
      read_arguments(split_outside_brackets(part.part(open + 1, text.size() - 1), ','), name, part.cursor(), term);
    return term;
  }

  /// What it is of, and the trajectory behind it, which may be left out.
  void read_arguments(const std::vector<TextPart>& given, const std::string& name, const SpecCursor& at,
                      ObjectiveTerm& term) {
    using Run = ObjectiveTerm::RunMeasure;
    const std::size_t own = term.run == Run::clearance ? 2 : term.run == Run::figure ? 1 : 0;
    const bool none = own == 0 && given.size() == 1 && given[0].text().empty();
    const std::size_t count = none ? 0 : given.size();
    if (count < own || count > own + 1) {
      const char* form = own == 2   ? "(point, point or line, trajectory)"
                         : own == 1 ? "(quantity, trajectory)"
                                    : "(trajectory)";
      at.fail({.expected = name + form, .found = quote_for_message(at.node().text)});
    }
    if (own == 1) term.quantity = read_quantity(given[0].cursor(), draft_.study);
    if (own == 2) {
      term.clearance.point = read_landmark(given[0].cursor(), draft_);
      for (const TextPart& end : ends_of_line(given[1]))
        term.clearance.target.push_back(read_landmark(end.cursor(), draft_));
    }
    term.trajectory = count > own ? read_trajectory_name(given[own].cursor(), draft_.study)
                                  : default_trajectory_name(at, draft_.study);
  }

  /// `leg2.A to leg2.B`
  static std::vector<TextPart> ends_of_line(const TextPart& part) {
    const std::size_t to = part.text().find(" to ");
    if (to == std::string::npos) return {part};
    return {part.part(0, to), part.part(to + 4, part.text().size())};
  }

  static void require_alone(const FigureLimit& limit, const SpecCursor& at) {
    using Run = ObjectiveTerm::RunMeasure;
    for (const ObjectiveTerm& term : limit.terms) {
      const bool least =
          term.size == ObjectiveTerm::Size::none && (term.run == Run::mobility || term.run == Run::clearance);
      if (least && (limit.terms.size() > 1 || term.weight != 1))
        at.fail({.expected = "mobility and clearance alone, not in a sum", .found = quote_for_message(at.node().text)});
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

  StudyBuilder& draft_;
};

}  // namespace

std::vector<FigureLimit> read_figure_limits(const SpecCursor& at, StudyBuilder& draft) {
  LimitReader reader(draft);
  if (!at.is_list()) return {reader.read(at)};
  std::vector<FigureLimit> limits;
  for (const SpecCursor& item : at.items("a list of limits"))
    at.problems().collect([&] { limits.push_back(reader.read(item)); });
  if (at.node().items.empty()) at.fail_expected("at least one limit");
  return limits;
}

}  // namespace balance::specification
