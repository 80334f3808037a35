#include "balance/interface/reports/formulas_sections.hpp"

#include "balance/foundation/base/latex_lines.hpp"
#include "balance/interface/files/json.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
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
  const auto contradicts = [&](const std::string& remaining) {
    return remaining == "1" ||
           std::find(section.nonzero.begin(), section.nonzero.end(), remaining) != section.nonzero.end();
  };
  for (const auto& formula : section.formulas)
    if (formula.label.empty())
      (contradicts(formula.text) ? has_contradiction : has_remaining) = true;
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

/// The value in the spec; 0 for what an expression of the spec leaves of others by round-off, as `r cos(pi/2)`.
double shown_value(const formulas::Ring& ring, const formulas::Symbol& symbol) {
  if (symbol.source.is_constant()) return symbol.value;
  double largest = 0;  // of its kind
  for (const formulas::Symbol& other : ring.symbols())
    if (other.kind == symbol.kind) largest = std::max(largest, std::abs(other.value));
  constexpr double round_off = 1e-15;
  return std::abs(symbol.value) <= round_off * largest ? 0 : symbol.value;
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
  std::vector<std::string> parameters, values;
  const auto& ring = *view.sheet->ring;
  const std::size_t parameter_count =
      view.is_spec_si ? 0 : view.sheet->equations.tree.model->parameters().size();  // the ring's first symbols
  for (std::size_t s = 0; s < ring.symbols().size(); ++s) {
    const formulas::Symbol& symbol = ring.symbols()[s];
    if (symbol.kind < formulas::SymbolKind::slide && names.contains(symbol.name))
      (s < parameter_count ? parameters : values)
          .push_back(fmt::format("{} = {:.6g}", symbol.name, shown_value(ring, symbol)));
  }
  for (const auto& angle : ring.angles())
    if (angle.is_fixed && names.contains(angle.name))
      values.push_back(fmt::format("{} = {:.6g}", angle.name, angle.value));
  const std::string in_si = values.empty() ? "" : fmt::format("{} in SI units", fmt::join(values, ", "));
  if (parameters.empty()) return values.empty() ? "" : "\nwhere " + in_si + "\n";
  return fmt::format("\nwhere {} in the spec's units{}{}\n", fmt::join(parameters, ", "),
                     values.empty() ? "" : ", and ", in_si);
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

/// Narrowest column beside a left side, in letters.
constexpr double min_latex_column_width = 24;

/// @param left of the sign of equality; empty: the right side is compared with zero
/// @param comparison with zero: "= 0" or "\neq 0"
std::string display_latex(const std::string& left, const std::string& right, const std::string& comparison = "= 0") {
  const std::string head = left.empty() ? "" : left + " = ", tail = left.empty() ? " " + comparison : "";
  const double head_width = latex_width(head);
  const bool is_beside = latex_line_width - head_width >= min_latex_column_width;
  const double limit = (is_beside ? latex_line_width - head_width : latex_line_width) - (left.empty() ? 3 : 0);
  const std::vector<std::string> lines = break_latex(right, limit);
  if (lines.size() < 2 && is_beside) return "\\[ " + head + lines.at(0) + tail + " \\]\n";
  std::string text = "\\begin{align*}\n" + (is_beside ? head + "{}& " : "& " + head + "\\\\\n  & {}") + lines.at(0);
  for (std::size_t k = 1; k < lines.size(); ++k) text += " \\\\\n  & {}" + lines[k];
  return text + tail + "\n\\end{align*}\n";
}

}  // namespace

std::string formulas_latex(const FormulasReportData& view) {
  std::string text;
  for (const PrintedSection& section : view.sections) {
    text += "% " + section.heading + "\n";
    if (section.is_left_out) text += "% " + length_note(section) + "\n";
    for (const auto& formula : section.formulas)
      text += display_latex(formulas::latex_label(formula.label), formula.text);
    for (const std::string& factor : section.nonzero) text += display_latex("", factor, "\\neq 0");
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
