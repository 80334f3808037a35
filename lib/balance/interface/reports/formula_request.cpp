#include "balance/interface/reports/formula_request.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/interface/specification/read_options.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/symbolic_conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace balance::reports {

namespace {

using formulas::SheetSectionKind;

/// What is read to print formulas.
struct FormulaSource {
  DesignSpace space;
  study::SpecNumberTexts texts;
  std::optional<formulas::SolveRequest> solve;
  RequestFailure refusal;
};

class FormulaDerivation {
 public:
  FormulaDerivation(const FormulaRequest& request, const std::string& text, const std::string& file, ReadOptions read)
      : request_(request), text_(text), file_(file), read_(std::move(read)), sections_(find_sections()) {
    source_ = read_source(read_);
    if (!request.solve.empty()) read_solvable();
    check_coordinates();
  }

  const FormulaSource& source() const { return source_; }
  const Study& study() const { return source_.space.start; }

  DerivedFormulas run() const {
    DerivedFormulas all;
    all.view.warnings = study().warnings;
    all.refusal = source_.refusal;
    if (all.refusal) return all;
    formulas::PrintOptions options;
    options.with_values = request_.with_values;
    if (request_.all) options.max_terms = std::numeric_limits<std::size_t>::max();
    all.sheet = std::make_unique<formulas::FormulaSheet>(make_sheet(sections_));
    options.collected = find_collected(*all.sheet->ring);
    all.view = check(*all.sheet, options);
    if (!all.view.check.is_consistent && sections_.empty() && !all.sheet->pivots.empty()) {
      // the steps of an elimination can be checked at fewer poses than what they are made of
      using enum SheetSectionKind;
      const std::string reason = "solved and reduced are left out: " + all.view.check.reason;
      *all.sheet = make_sheet({inertia, velocity, gravity, closures});
      all.sheet->notes.push_back(reason);
      options.collected = find_collected(*all.sheet->ring);
      all.view = check(*all.sheet, options);
    }
    if (!all.view.check.is_consistent) {
      all.refusal = {"no-formulas", fmt::format("no formulas: {} (checked at {} states: {:.0e})", all.view.check.reason,
                                                all.view.check.states, all.view.check.error)};
      return all;
    }
    if (!request_.latex) return all;
    all.latex = all.view;
    options.style = formulas::PrintStyle::latex;
    all.latex.sections = print_sheet(*all.sheet, options);
    return all;
  }

 private:
  std::string name_of(const std::string& argument) const { return request_.prefix + argument; }

  std::vector<SheetSectionKind> find_sections() const {
    const std::vector<std::string>& names = formulas::sheet_section_names();
    std::vector<SheetSectionKind> sections;
    for (const std::string& name : request_.only) {
      const auto at = std::find(names.begin(), names.end(), name);
      if (at == names.end())
        throw FormulaRequestError(fmt::format("{} without {} needs {}, not {}{}", name_of("only"), name_of("at"),
                                              fmt::join(names, ", "), quote_for_message(name),
                                              append_nearest_name(name, names)));
      sections.push_back(static_cast<SheetSectionKind>(at - names.begin()));
      using enum SheetSectionKind;
      if ((sections.back() == solutions || sections.back() == balanced) && request_.solve.empty())
        throw FormulaRequestError(fmt::format("{} {} needs {} NAMES", name_of("only"), name, name_of("solve")));
    }
    return sections;
  }

  bool asks_for(SheetSectionKind section) const {
    return std::find(sections_.begin(), sections_.end(), section) != sections_.end();
  }

  FormulaSource read_source(const ReadOptions& read) const {
    FormulaSource source;
    source.space = read_design_space(text_, file_, read);
    Mechanism& mechanism = source.space.start.mechanism;
    mechanism = model::mechanism_in_interval(mechanism, {}, 0);  // symbols stand for all payloads
    source.texts = read_spec_number_texts(source.space, read);
    return source;
  }

  /// Reads the spec again, such that the numbers to solve for can have any value: parameters without their expressions,
  /// numbers of the mechanism as inputs.
  void read_solvable() {
    formulas::SolveRequest request;
    try {
      request.unknowns = formulas::find_unknown_numbers(study().mechanism, source_.texts, request_.solve);
    } catch (const std::invalid_argument& error) {
      throw FormulaRequestError(name_of("solve") + ": " + error.what());
    }
    ReadOptions read = read_;
    for (const formulas::UnknownNumber& unknown : request.unknowns) {
      if (unknown.parameter.empty()) read.inputs.insert(unknown.path);
      for (const study::NamedExpression& parameter : source_.texts.recording->parameters)
        if (parameter.name == unknown.parameter && !parameter.is_plain)
          read.set.emplace_back(parameter.name, fmt::format("{:.17g}", parameter.value.value()));
    }
    for (std::string& path : formulas::list_inertial_paths(study().mechanism, source_.texts))
      read.inputs.insert(std::move(path));
    FormulaSource solvable = read_source(read);
    const Study& study = solvable.space.start;
    const BalanceRequest balance = request_.balance(study);
    request.goals = balance.goals;
    ConditionOptions options;
    options.seed = balance.seed.value_or(options.seed);
    options.excluded = balance.excluded;
    options.speeds = conditions::ChosenSpeeds(study.mechanism, study.design.speeds);
    if (options.speeds.depend_on_masses())
      throw FormulaRequestError(
          name_of("solve") +
          ": conditions in speeds of the centre of mass are not linear in the masses, which move it");
    if (!study.trajectories.empty()) options.about = study.trajectories.front().about;
    options.motions = study::select_goal_motions(balance.goals, study.trajectories);
    request.derive =
        make_conditions_deriver(balance.goals, balance.is_modular, options, simulation::start_coordinates(study));
    if (balance.is_modular || !balance.excluded.empty() || !options.speeds.empty() ||
        !formulas::has_symbolic_conditions(study.mechanism, balance.goals)) {
      ConditionsOutcome conditions = derive_conditions_data(balance, solvable.space);
      solvable.refusal = conditions.refusal;
      request.conditions = std::move(conditions.view.conditions);
      request.names = std::move(conditions.view.names);
    }
    solvable.solve = std::move(request);
    source_ = std::move(solvable);
  }

  void check_coordinates() {
    const Mechanism& mechanism = study().mechanism;
    if (mechanism.coordinates.empty())
      source_.refusal = {"mismatch", "the mechanism has no degrees of freedom: there is no equation of motion"};
    std::vector<std::string> names;
    for (const Coordinate& coordinate : mechanism.coordinates) names.push_back(coordinate.name);
    for (const std::string& name : request_.independent)
      if (std::find(names.begin(), names.end(), name) == names.end())
        throw FormulaRequestError(fmt::format("{}: there is no coordinate {}{}", name_of("independent"),
                                              quote_for_message(name), append_nearest_name(name, names)));
  }

  /// Those of a mechanism with loops or constraints on speeds, and forms of the spec's goals that are not in the sheet.
  std::vector<Goal> list_goals_to_derive() const {
    std::vector<Goal> goals;
    using enum GoalKind;
    if (!formulas::is_open_chain(study().mechanism))
      for (const GoalKind kind : {statics, force, gyroscopic, decoupled}) goals.push_back({.kind = kind});
    for (const Goal& goal : study().design.goals)
      if (!is_whole(goal)) goals.push_back(goal);
    return goals;
  }

  /// Conditions as `balance conditions` derives them.
  std::vector<formulas::GoalConditions> derive_goal_conditions() const {
    if (!asks_for(SheetSectionKind::conditions)) return {};
    std::vector<formulas::GoalConditions> list;
    for (const Goal& goal : list_goals_to_derive()) {
      formulas::GoalConditions one{goal, {}, {}, ""};
      BalanceRequest balance;
      balance.goals = {one.goal};
      ConditionsOutcome outcome = derive_conditions_data(balance, source_.space);
      one.reason = outcome.refusal.reason;
      one.conditions = std::move(outcome.view.conditions);
      one.names = std::move(outcome.view.names);
      list.push_back(std::move(one));
    }
    return list;
  }

  formulas::FormulaSheet make_sheet(std::vector<SheetSectionKind> sections) const {
    const auto expressions =
        request_.expand ? formulas::ParameterExpressions::inlined : formulas::ParameterExpressions::symbols;
    std::vector<model::GeneralisedSpeed> speeds;
    if (!request_.speeds.empty()) {
      speeds = specification::read_speeds(request_.speeds, name_of("speeds").c_str(),
                                          specification::SpeedUse::quasi_velocity, study());
    } else if (asks_for(SheetSectionKind::speeds)) {
      speeds = study().speeds;
      if (speeds.empty())
        throw FormulaRequestError(
            fmt::format("{} speeds needs {}, or speeds in the spec", name_of("only"), name_of("speeds")));
    }
    formulas::FormulaSheet sheet =
        formulas::make_sheet(study().mechanism, source_.texts,
                             {std::move(sections), expressions, source_.solve, request_.independent,
                              derive_goal_conditions(), std::move(speeds)});
    for (const study::TemporaryPayload& payload : study().temporary_payloads)
      sheet.notes.push_back(
          fmt::format("payload '{}' is not always there: without it, its mass and inertia are 0", payload.name));
    return sheet;
  }

  std::vector<int> find_collected(const formulas::Ring& ring) const {
    std::vector<int> found;
    std::vector<std::string> known;
    for (const formulas::Symbol& symbol : ring.symbols()) known.push_back(symbol.name);
    for (const std::string& name : request_.collect) {
      const auto at = std::find(known.begin(), known.end(), name);
      if (at == known.end())
        throw FormulaRequestError(fmt::format("{}: {} is no symbol of these formulas{}", name_of("collect"),
                                              quote_for_message(name), append_nearest_name(name, known)));
      found.push_back(static_cast<int>(at - known.begin()));
    }
    return found;
  }

  bool is_spec_si() const {
    const specification::SpecUnits units = specification::read_display_units(study().spec_text);
    return units.length == 1 && units.angle == 1 && units.mass == 1 && units.time == 1 && units.force == 1;
  }

  FormulasReportData check(const formulas::FormulaSheet& sheet, const formulas::PrintOptions& options) const {
    const std::string& name = study().mechanism.name;
    FormulasReportData view{name.empty() ? study().spec_file : name,
                            &sheet,
                            print_sheet(sheet, options),
                            {},
                            study().warnings,
                            is_spec_si()};
    view.check = formulas::check_against_engine(sheet, texts_by_label(view.sections), study().mechanism,
                                                {.with_perturbed_parameters = !request_.with_values});
    return view;
  }

  const FormulaRequest& request_;
  const std::string &text_, &file_;
  ReadOptions read_;
  std::vector<SheetSectionKind> sections_;
  FormulaSource source_;
};

RequestFailure failure_of(const formulas::FormulaError& error) {
  return {"no-formulas", std::string("no formulas: ") + error.what()};
}

}  // namespace

DerivedFormulas derive_formulas(const FormulaRequest& request, const std::string& text, const std::string& file,
                                const ReadOptions& read) {
  const FormulaDerivation derivation(request, text, file, read);
  try {
    return derivation.run();
  } catch (const formulas::IndependentCoordinatesError& error) {
    throw FormulaRequestError(request.prefix + "independent: " + error.what());
  } catch (const formulas::FormulaError& error) {
    DerivedFormulas none;
    none.refusal = failure_of(error);
    none.view.warnings = derivation.study().warnings;
    return none;
  }
}

GeneratedProgram generate_program_of(const FormulaRequest& request, formulas::Language language,
                                     formulas::ProgramCoordinates coordinates, const std::string& text,
                                     const std::string& file, const ReadOptions& read) {
  const FormulaDerivation derivation(request, text, file, read);
  const Study& study = derivation.study();
  GeneratedProgram program{derivation.source().refusal, "", study.warnings};
  if (program.refusal) return program;
  try {
    program.code = formulas::generate_program(study.mechanism, derivation.source().texts, language, nullptr,
                                              {coordinates, request.independent, simulation::start_coordinates(study)});
  } catch (const formulas::IndependentCoordinatesError& error) {
    throw FormulaRequestError(request.prefix + "independent: " + error.what());
  } catch (const formulas::FormulaError& error) {
    program.refusal = failure_of(error);
  }
  return program;
}

}  // namespace balance::reports
