#include "formulas.hpp"

#include "console.hpp"
#include "failure.hpp"

#include "balance/base/nearest.hpp"
#include "balance/formulas/code.hpp"
#include "balance/present/formulas_text.hpp"
#include "balance/spec/spec_texts.hpp"
#include "balance/spec/text_file.hpp"
#include "balance/study/passing_payloads.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

namespace balance::app {
namespace {

std::vector<formulas::SheetSectionKind> sections_of(const FormulaOptions& options) {
  const std::vector<std::string>& names = formulas::sheet_section_names();
  std::vector<formulas::SheetSectionKind> sections;
  for (const std::string& name : options.only) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
      throw UsageError(fmt::format("--only without --at needs {}, not {}{}", fmt::join(names, ", "),
                                   quote_for_message(name), append_nearest_name(name, names)));
    sections.push_back(static_cast<formulas::SheetSectionKind>(at - names.begin()));
  }
  return sections;
}

std::string title_of(const Study& study) {
  return study.mechanism.name.empty() ? study.spec_file : study.mechanism.name;
}

void print_view(const FormulaOptions& options, const Study& study, const SpecNumberTexts& texts) {
  const auto expressions =
      options.expand ? formulas::ParameterExpressions::inlined : formulas::ParameterExpressions::symbols;
  const formulas::FormulaSheet sheet =
      formulas::make_sheet(study.mechanism, texts, {sections_of(options), expressions});
  formulas::PrintOptions print_options;
  print_options.with_values = options.numbers;
  if (options.all) print_options.max_terms = std::numeric_limits<std::size_t>::max();
  FormulasReportData view{title_of(study), &sheet, print_sheet(sheet, print_options), {}, study.warnings};
  view.check = check_against_engine(sheet, texts_by_label(view.sections), study.mechanism,
                                    {.with_perturbed_parameters = !options.numbers});
  if (!view.check.is_consistent)
    throw MechanismFailure("no-formulas", fmt::format("no formulas: {} (checked at {} states: {:.0e})",
                                                      view.check.reason, view.check.states, view.check.error));
  if (options.latex) {
    print_options.style = formulas::PrintStyle::latex;
    view.sections = print_sheet(sheet, print_options);
  }
  if (options.spec.json)
    print(formulas_json(view));
  else
    print_text(options.latex ? formulas_latex(view) : formulas_text(view));
}

}  // namespace

ExitCode print_formulas(const FormulaOptions& options) {
  sections_of(options);
  const std::string text = read_text_file(options.spec.spec, "spec");
  const DesignSpace space = read_design_space(text, display_name(options.spec.spec), read_options(options.spec));
  const Study& study = space.start;
  reject_temporary_payloads(study, "equations of motion");
  if (study.mechanism.coordinates.empty())
    throw MechanismFailure("mismatch", "the mechanism has no degrees of freedom: there is no equation of motion");
  const SpecNumberTexts texts = read_spec_number_texts(space, read_options(options.spec));
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  try {
    if (options.code.empty()) {
      print_view(options, study, texts);
    } else {
      const auto language = options.code == "python" ? formulas::Language::python : formulas::Language::c;
      print(formulas::generate_program(study.mechanism, texts, language));
    }
  } catch (const formulas::FormulaError& error) {
    throw MechanismFailure("no-formulas", std::string("no formulas: ") + error.what());
  }
  return ExitCode::done;
}

}  // namespace balance::app
