#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/reports/formula_request.hpp"
#include "balance/interface/specification/display_units.hpp"

#include <stdexcept>

namespace balance::python {
namespace {

/// Goals of the spec, unless others are named.
std::function<reports::BalanceRequest(const Study&)> balance_of(GoalArguments arguments) {
  return [arguments = std::move(arguments)](const Study& study) {
    reports::BalanceRequest request = question_of(arguments, study);
    if (request.goals.empty()) request.goals = study.design.goals;
    if (request.goals.empty())
      throw std::invalid_argument("the spec has no design: goal, so a goal is needed: " +
                                  join_alternatives(study::goal_names()));
    return request;
  };
}

struct PrintedFormulas {
  reports::RequestFailure refusal;
  std::string json, text, latex;
};

py::dict equations(const std::shared_ptr<Spec>& spec, std::vector<std::string> only, std::vector<std::string> solve,
                   std::vector<std::string> collect, std::vector<std::string> independent, std::string speeds,
                   const std::vector<bool>& flags, GoalArguments goal) {
  reports::FormulaRequest request;
  request.only = std::move(only), request.solve = std::move(solve), request.collect = std::move(collect);
  request.independent = std::move(independent), request.speeds = std::move(speeds);
  request.expand = flags.at(0), request.with_values = flags.at(1), request.all = flags.at(2);
  request.latex = true;
  request.prefix = "";
  request.balance = balance_of(std::move(goal));
  const PrintedFormulas printed = compute_in_background([spec, request](BackgroundTask&) {
    const reports::DerivedFormulas found = derive_formulas(request, spec->text, spec->file, spec->read);
    PrintedFormulas all;
    all.refusal = found.refusal;
    if (all.refusal) return all;
    all.json = formulas_json(found.view);
    all.text = formulas_text(found.view);
    all.latex = formulas_latex(found.latex);
    return all;
  });
  if (printed.refusal) refuse(printed.refusal);
  py::dict all;
  all["json"] = printed.json;
  all["text"] = printed.text;
  all["latex"] = printed.latex;
  return all;
}

std::string program(const std::shared_ptr<Spec>& spec, const std::string& language, const std::string& coordinates,
                    std::vector<std::string> independent) {
  require_one_of({"c", "python"}, language, "language");
  require_one_of({"independent", "all"}, coordinates, "coordinates");
  reports::FormulaRequest request;
  request.independent = std::move(independent);
  request.prefix = "";
  const reports::GeneratedProgram found = compute_in_background([=](BackgroundTask&) {
    return generate_program_of(
        request, language == "c" ? formulas::Language::c : formulas::Language::python,
        coordinates == "all" ? formulas::ProgramCoordinates::all : formulas::ProgramCoordinates::independent,
        spec->text, spec->file, spec->read);
  });
  if (found.refusal) refuse(found.refusal);
  return found.code;
}

}  // namespace

void bind_equations(py::module_& m) {
  m.def(
      "equations",
      [](const std::shared_ptr<Spec>& spec, std::vector<std::string> only, std::vector<std::string> solve,
         std::vector<std::string> collect, std::vector<std::string> independent, std::string speeds, bool expand,
         bool numbers, bool all, std::vector<std::string> goals, std::vector<std::string> without, std::string strategy,
         std::optional<std::uint64_t> seed) {
        return equations(spec, std::move(only), std::move(solve), std::move(collect), std::move(independent),
                         std::move(speeds), {expand, numbers, all},
                         {std::move(goals), std::move(without), std::move(strategy), seed});
      },
      py::arg("spec"), py::arg("only"), py::arg("solve"), py::arg("collect"), py::arg("independent"), py::arg("speeds"),
      py::arg("expand"), py::arg("numbers"), py::arg("all"), py::arg("goals"), py::arg("without"), py::arg("strategy"),
      py::arg("seed"));
  m.def("program", &program, py::arg("spec"), py::arg("language"), py::arg("coordinates"), py::arg("independent"));
  m.attr("formula_sections") = formulas::sheet_section_names();
}

}  // namespace balance::python
