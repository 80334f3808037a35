#include "balance/interface/reports/report_data.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/reports/order_condition_sections.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/condition_notes.hpp"
#include "balance/synthesis/conditions/spec_symbols.hpp"
#include "balance/synthesis/design/condition_dependence.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <algorithm>
#include <limits>

namespace balance::reports {

namespace {

/// "g is 0 in the spec": the parameters with which gravity would not vanish; empty if there is gravity, or none at all.
std::string describe_vanishing_gravity(const DesignSpace& space) {
  if (!space.recording || space.start.mechanism.gravity.norm() > 0) return "";
  const study::Recording& recording = *space.recording;
  std::string names;
  for (const study::NamedExpression& parameter : recording.parameters) {
    if (!parameter.is_plain || parameter.value.is_constant() || parameter.value.value() != 0) continue;
    std::vector<double> inputs = recording.inputs;
    inputs[static_cast<std::size_t>(recording.input_index(parameter.value))] = 1;
    const study::RecordedValues<double> changed(recording, inputs);
    const auto& gravity = recording.mechanism.gravity;
    if (std::any_of(gravity.begin(), gravity.end(), [&](const Expression& g) { return changed(g) != 0; }))
      names += (names.empty() ? "" : ", ") + parameter.name;
  }
  return names.empty() ? "" : names + (names.find(',') == std::string::npos ? " is" : " are") + " 0 in the spec";
}

}  // namespace

ConditionsOutcome derive_conditions_data(const BalanceRequest& request, const DesignSpace& space, bool with_names) {
  const Study& study = space.start;
  const std::vector<CoordinateValue> start = simulation::start_coordinates(study);
  ConditionsOutcome outcome;
  ConditionOptions options;
  options.seed = request.seed.value_or(options.seed);
  options.excluded = request.excluded;
  options.speeds =
      conditions::ChosenSpeeds(study.mechanism, request.speeds.empty() ? study.design.speeds : request.speeds);
  if (request.is_modular && !options.speeds.empty()) {
    outcome.refusal = {"mismatch",
                       "goals in chosen speeds are those of the whole mechanism, not of the chains one by one"};
    return outcome;
  }
  with_names = with_names && !options.speeds.has_parameters() && !options.speeds.depend_on_masses();
  // the same reference point of angular momentum as in the runs
  if (!study.trajectories.empty()) options.about = study.trajectories.front().about;
  options.motions = study::select_goal_motions(request.goals, study.trajectories);
  const DeriveConditions derive = make_conditions_deriver(request.goals, request.is_modular, options, start);
  ConditionsReportData& view = outcome.view;
  view.title = study.mechanism.name;
  view.strategy = request.strategy();
  view.conditions = derive(study.mechanism);
  if (const std::string vanishing = describe_vanishing_gravity(space); !vanishing.empty())
    for (std::string& note : view.conditions.notes)
      if (note == conditions::no_gravity_note)
        note = vanishing + ": weight imposes no condition, but does with another value (--set)";
  if (view.conditions.status != ConditionsStatus::done) {
    outcome.refusal = {design::name_of(view.conditions.status), view.conditions.reason};
    return outcome;
  }
  if (with_names) {
    const DeriveConditions perturbed_derive =
        make_perturbed_deriver(derive, request.is_modular, options, start, study.mechanism, view.conditions);
    view.names = name_coefficients(study.mechanism, view.conditions, conditions::list_symbols(space), perturbed_derive);
  }
  view.numbers = study.free_numbers;
  view.free_number_indices = design::probe_condition_variables(space, view.conditions, derive);
  evaluate_conditions(view, simulation::assembled_at(study.mechanism, start), study.trajectories, options);
  if (with_names) name_orders(view, study.mechanism, conditions::list_symbols(space), options, start);
  if (!view.residuals.allFinite())
    outcome.refusal = {"overflow",
                       has_mass(study.mechanism)
                           ? "numbers overflow: the residuals of the conditions are too large to compute with"
                           : model::no_mass_message};
  return outcome;
}

RequestFailure find_failure(const DesignReport& report) {
  const Conditions& conditions = report.outcome.conditions;
  if (report.outcome.status != DesignStatus::unsolved) return {};
  // the conditions exist, so the objective has no value
  return {conditions.status == ConditionsStatus::done ? "no-value" : design::name_of(conditions.status),
          report.outcome.reason.empty() ? conditions.reason : report.outcome.reason};
}

namespace {

/// Symbols in the design's own spec, as in the file that -o writes.
std::vector<conditions::GeometricSymbol> symbols_of_design(const Study& study, const std::string& balanced,
                                                           const Mechanism& mechanism,
                                                           std::vector<std::string>& notes) {
  try {
    return conditions::list_symbols(read_design_space(balanced, study.spec_file));
  } catch (const SpecError& error) {
    notes.push_back("the designed spec needs a change before it can be read: " + error.summary());
    return conditions::list_geometric_symbols(mechanism);
  }
}

ConditionsReportData make_designed_conditions_data(const DesignStudyOptions& options, const DesignSpace& space,
                                                   const std::string& balanced, DesignReport& report) {
  const design::DesignOutcome& outcome = report.outcome;
  const Mechanism& mechanism = report.study_after.mechanism;
  ConditionsReportData view;
  view.title = space.start.mechanism.name;
  view.strategy = options.is_modular ? "modular" : "complete";
  view.conditions = outcome.conditions;
  view.numbers = report.free_numbers;
  if (view.conditions.goals.empty()) {  // only an objective was given
    view.residuals = VectorX(0);
    return view;
  }
  const dynamics::FreeSprings loose = loose_springs_of(view.conditions, mechanism);
  ConditionOptions condition_options;
  condition_options.loose_springs = loose;
  condition_options.excluded = options.excluded;
  condition_options.variable_terms = view.conditions.variable_terms;
  condition_options.speeds = conditions::ChosenSpeeds(space.start.mechanism, space.start.design.speeds);
  if (!space.start.trajectories.empty()) condition_options.about = space.start.trajectories.front().about;
  condition_options.motions = study::select_goal_motions(view.conditions.goals, report.study_after.trajectories);
  const auto symbols = symbols_of_design(space.start, balanced, mechanism, report.notes);
  const auto start = simulation::start_coordinates(space.start);
  const DeriveConditions derive =
      make_conditions_deriver(view.conditions.goals, options.is_modular, condition_options, start);
  const bool has_fixed_factors =
      !condition_options.speeds.has_parameters() && !condition_options.speeds.depend_on_masses();
  if (has_fixed_factors)
    view.names = name_coefficients(
        mechanism, view.conditions, symbols,
        make_perturbed_deriver(derive, options.is_modular, condition_options, start, mechanism, view.conditions));
  view.free_number_indices = outcome.condition_variables;
  view.free_number_indices.resize(static_cast<std::size_t>(view.conditions.matrix.rows()));
  evaluate_conditions(view, simulation::assembled_at(mechanism, simulation::start_coordinates(space.start)),
                      report.study_after.trajectories, condition_options);
  name_orders(view, mechanism, symbols, condition_options, start);
  return view;
}

}  // namespace

DesignReportData make_design_data(const DesignStudyOptions& options, const DesignSpace& space,
                                  const std::string& balanced, DesignReport report) {
  DesignReportData view;
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  view.objective = objective_text(terms);
  view.objective_unit = simulation::objective_unit(terms, space.start.mechanism);
  view.conditions = make_designed_conditions_data(options, space, balanced, report);
  const Eigen::Index rows = view.conditions.conditions.matrix.rows();
  view.residuals_before = report.outcome.residuals_before.size() == rows
                              ? report.outcome.residuals_before
                              : VectorX::Constant(rows, std::numeric_limits<double>::quiet_NaN());
  for (const ObjectiveTerm& term : terms) view.trajectories.push_back(term.trajectory);
  for (const study::FigureLimit& limit : space.start.design.subject_to)
    for (const ObjectiveTerm& term : limit.terms) view.trajectories.push_back(term.trajectory);
  std::erase(view.trajectories, "");
  view.seconds = options.search.max_time;
  view.warnings = space.start.warnings;
  view.report = std::move(report);
  return view;
}

}  // namespace balance::reports
