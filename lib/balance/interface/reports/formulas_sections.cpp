#include "balance/interface/reports/formulas_sections.hpp"

#include "balance/interface/files/json.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <set>

namespace balance::reports {

namespace {

using formulas::PrintedSection;

Json formula_json(const formulas::PrintedFormula& formula) {
  return {{"name", formula.label}, {"formula", formula.text}};
}

std::string line_of(const formulas::PrintedFormula& formula) {
  return formula.label.empty() ? formula.text + " = 0" : formula.label + " = " + formula.text;
}

/// What must not vanish, what is not solved for, and values with the spec's numbers.
std::string solution_text(const PrintedSection& section) {
  std::string text;
  std::vector<std::string> values;
  bool has_remaining = false, has_contradiction = false;
  for (const auto& formula : section.formulas)
    if (formula.label.empty())
      (formula.text == "1" ? has_contradiction : has_remaining) = true;
    else if (formula.value)
      values.push_back(fmt::format("{} = {:.6g}", formula.label, *formula.value));
  if (has_contradiction) text += "  a contradiction: no values of these numbers meet the goal\n";
  if (has_remaining) text += "  what is equal to 0 remains to be met\n";
  if (!section.nonzero.empty())
    text += fmt::format("  where {} {} not 0\n", fmt::join(section.nonzero, ", "),
                        section.nonzero.size() == 1 ? "is" : "are");
  for (const auto& one : section.unsolved) text += fmt::format("  {} {}\n", one.name, one.reason);
  if (!values.empty()) text += fmt::format("  with the spec's numbers: {}\n", fmt::join(values, ", "));
  return text;
}

std::string length_note(const PrintedSection& section) {
  if (!section.used_left_out.empty())
    return fmt::format("left out like {}, whose names it uses: --all prints them", section.used_left_out);
  if (section.section == formulas::SheetSectionKind::natural)
    return fmt::format("{} terms: --all prints them", section.terms);
  return fmt::format("{} terms: --code c prints them as a program, --all as formulas", section.terms);
}

/// Names in the formulas, with their values in the spec.
std::string symbols_line(const FormulasReportData& view) {
  std::set<std::string> names;
  for (const PrintedSection& section : view.sections)
    for (const auto& formula : section.formulas) {
      std::string name;
      for (const char c : formula.text + " ") {
        const bool is_name_char = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
        if (!is_name_char) names.insert(name);
        name = is_name_char ? name + c : "";
      }
    }
  std::vector<std::string> values;
  const auto& ring = *view.sheet->ring;
  for (const auto& symbol : ring.symbols())
    if (symbol.kind < formulas::SymbolKind::slide && names.contains(symbol.name))
      values.push_back(fmt::format("{} = {:.6g}", symbol.name, symbol.value));
  for (const auto& angle : ring.angles())
    if (angle.is_fixed && names.contains(angle.name))
      values.push_back(fmt::format("{} = {:.6g}", angle.name, angle.value));
  return values.empty() ? "" : fmt::format("\nwhere {} in SI units\n", fmt::join(values, ", "));
}

}  // namespace

std::string formulas_text(const FormulasReportData& view, std::size_t width) {
  std::string text = fmt::format("{}\n", view.title);
  text += fmt::format("coordinates: {}\n", fmt::join(view.sheet->equations.tree.columns, ", "));
  for (const PrintedSection& section : view.sections) {
    text += fmt::format("\n{}\n", section.heading);
    if (section.is_left_out) text += "  " + length_note(section) + "\n";
    for (const auto& formula : section.formulas) text += "  " + line_of(formula) + "\n";
    if (!section.zero.empty()) text += fmt::format("  zero: {}\n", fmt::join(section.zero, ", "));
    if (section.section == formulas::SheetSectionKind::solutions) text += solution_text(section);
    if (section.formulas.empty() && section.zero.empty() && !section.is_left_out && section.unsolved.empty())
      text += "  none: always met\n";
  }
  text += symbols_line(view);
  for (const std::string& note : view.sheet->notes) text += "note: " + note + "\n";
  if (!view.check.note.empty()) text += "note: " + view.check.note + "\n";
  const std::string perturbed_note = view.check.perturbed_states > 0
                                         ? fmt::format(", {} of them with other numbers", view.check.perturbed_states)
                                         : "";
  if (view.check.solution_states > 0)
    text +=
        fmt::format("the solution meets the engine's conditions with {} set{} of other numbers: {:.0e}\n",
                    view.check.solution_states, view.check.solution_states == 1 ? "" : "s", view.check.solution_error);
  text += fmt::format("checked at {} states{}: {:.0e}\n", view.check.states, perturbed_note, view.check.error);
  return files::wrap_lines(text, width);
}

namespace {

/// About the width of a line of text in an article, in letters.
constexpr double latex_line_width = 46;
constexpr double index_width = 0.7;  ///< of a letter, relative to one on the line

/// A sign between terms, where a formula may be broken.
struct BreakPoint {
  std::size_t position = 0;
  int depth = 0;     ///< of brackets around it
  double width = 0;  ///< of what stands before it
};

/// Signs between terms outside fractions and indices, with the width before them; the last one is the end.
std::vector<BreakPoint> list_break_points(const std::string& latex) {
  std::vector<BreakPoint> points;
  int brackets = 0, braces = 0;
  double width = 0;
  for (std::size_t k = 0; k < latex.size(); ++k) {
    const char c = latex[k];
    if (c == '\\') {
      std::size_t end = k + 1;
      while (end < latex.size() && std::isalpha(static_cast<unsigned char>(latex[end])) != 0) ++end;
      const std::string command = latex.substr(k + 1, end - k - 1);
      if (command.empty())  // a thin space
        ++end;
      else if (command == "sin" || command == "cos")
        width += 3;
      else if (command != "left" && command != "right" && command != "mathrm" && command != "frac" &&
               command != "tfrac")
        width += 1;
      k = end - 1;
    } else if (c == '{' || c == '}') {
      braces += c == '{' ? 1 : -1;
    } else if (c == '(' || c == ')') {
      brackets += c == '(' ? 1 : -1;
      width += 1;
    } else if (c != ' ' && c != '_' && c != '^') {
      const bool is_sign =
          (c == '+' || c == '-') && k > 0 && latex[k - 1] == ' ' && k + 1 < latex.size() && latex[k + 1] == ' ';
      if (is_sign && braces == 0) points.push_back({k, brackets, width});
      width += is_sign ? 2 : braces > 0 ? index_width : 1;
    }
  }
  points.push_back({latex.size(), 0, width});
  return points;
}

/// Several lines, broken at signs as far outside brackets as possible; brackets may span lines.
std::vector<std::string> break_latex(const std::string& latex) {
  const std::vector<BreakPoint> points = list_break_points(latex);
  std::vector<std::string> lines;
  std::size_t begin = 0, next = 0;
  double before = 0;
  while (begin < latex.size()) {
    std::size_t chosen = points.size() - 1;
    if (points.back().width - before > latex_line_width) {
      chosen = next;
      for (std::size_t k = next; k < points.size() && points[k].width - before <= latex_line_width; ++k)
        if (points[k].depth <= points[chosen].depth || points[chosen].width - before < 0.3 * latex_line_width)
          chosen = k;
    }
    lines.push_back(latex.substr(begin, points[chosen].position - begin));
    begin = points[chosen].position;
    before = points[chosen].width;
    next = std::min(chosen + 1, points.size() - 1);
  }
  return lines;
}

std::string with_all_replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

std::string display_latex(const std::string& left, const std::string& right) {
  const std::vector<std::string> lines = break_latex(right);
  if (lines.size() < 2) return "\\[ " + (left.empty() ? right + " = 0" : left + " = " + right) + " \\]\n";
  std::string text = "\\begin{align*}\n" + (left.empty() ? "" : left + " = ") + "{}& " + lines[0];
  for (std::size_t k = 1; k < lines.size(); ++k) text += " \\\\\n  & {}" + lines[k];
  if (left.empty()) text += " = 0";
  // \left and \right belong to one line
  return with_all_replaced(with_all_replaced(text, "\\left(", "\\bigl("), "\\right)", "\\bigr)") + "\n\\end{align*}\n";
}

}  // namespace

std::string formulas_latex(const FormulasReportData& view) {
  std::string text;
  for (const PrintedSection& section : view.sections) {
    text += "% " + section.heading + "\n";
    if (section.is_left_out) text += "% " + length_note(section) + "\n";
    for (const auto& formula : section.formulas)
      text += display_latex(formulas::latex_label(formula.label), formula.text);
    for (const std::string& factor : section.nonzero) text += "\\[ " + factor + " \\neq 0 \\]\n";
    for (const auto& one : section.unsolved) text += "% " + one.name + " " + one.reason + "\n";
  }
  return text;
}

std::string formulas_json(const FormulasReportData& view) {
  Json json = {{"mechanism", view.title}, {"coordinates", view.sheet->equations.tree.columns}};
  if (!view.sheet->independent.empty()) {
    json["independent"] = Json::array();
    for (const int column : view.sheet->independent)
      json["independent"].push_back(view.sheet->equations.tree.columns[static_cast<std::size_t>(column)]);
  }
  json["sections"] = Json::array();
  for (const PrintedSection& section : view.sections) {
    json["sections"].push_back({{"section", formulas::sheet_section_names()[static_cast<std::size_t>(section.section)]},
                                {"meaning", section.heading},
                                {"terms", section.terms},
                                {"too_long", section.is_left_out},
                                {"formulas", files::list_json(section.formulas, formula_json)},
                                {"zero", section.zero}});
    if (section.section != formulas::SheetSectionKind::solutions) continue;
    Json& added = json["sections"].back();
    for (std::size_t k = 0; k < section.formulas.size(); ++k)
      added["formulas"][k]["value"] = section.formulas[k].value ? Json(*section.formulas[k].value) : Json();
    added["nonzero"] = section.nonzero;
    added["unsolved"] = Json::array();
    for (const auto& one : section.unsolved) added["unsolved"].push_back({{"name", one.name}, {"reason", one.reason}});
  }
  json["symbols"] = Json::object();
  for (const auto& symbol : view.sheet->ring->symbols())
    if (symbol.kind < formulas::SymbolKind::slide) json["symbols"][symbol.name] = symbol.value;
  for (const auto& angle : view.sheet->ring->angles())
    if (angle.is_fixed) json["symbols"][angle.name] = angle.value;
  json["notes"] = view.sheet->notes;
  if (!view.check.note.empty()) json["notes"].push_back(view.check.note);
  json["checked"] = {
      {"states", view.check.states}, {"other_numbers", view.check.perturbed_states}, {"error", view.check.error}};
  if (view.sheet->solution)
    json["solution_checked"] = {{"states", view.check.solution_states}, {"error", view.check.solution_error}};
  json["warnings"] = view.warnings;
  return files::format_json(json);
}

}  // namespace balance::reports
