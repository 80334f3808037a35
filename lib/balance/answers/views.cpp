#include "balance/answers/views.hpp"

#include "balance/analysis/occurrence.hpp"
#include "balance/analysis/start_pose.hpp"
#include "balance/base/error.hpp"
#include "balance/conditions/symbols.hpp"
#include "balance/model/validate.hpp"
#include "balance/present/names.hpp"
#include "balance/spec/read_spec.hpp"
#include "balance/study/passing_payloads.hpp"

#include <limits>

namespace balance {

ConditionsAnswer derive_view(const BalanceQuestion& question, const DesignSpace& space, bool named) {
  const Study& study = space.start;
  const std::vector<CoordinateValue> start = start_coordinates(study);
  refuse_passing_payloads(study, "conditions", &question.without);
  ConditionOptions options;
  options.seed = question.seed.value_or(options.seed);
  options.without = question.without;
  // Angular momentum is about the same point as in the runs.
  if (!study.trajectories.empty()) options.about = study.trajectories.front().about;
  const Derive derive = make_derive(question.goals, question.modular, options, start);
  ConditionsAnswer answer;
  ConditionsView& view = answer.view;
  view.title = study.mechanism.name;
  view.strategy = question.strategy();
  view.conditions = derive(study.mechanism);
  if (view.conditions.status != ConditionsStatus::done) {
    answer.refusal = {name_of(view.conditions.status), view.conditions.reason};
    return answer;
  }
  if (named) {
    const Derive nearby =
        make_derive_nearby(derive, question.modular, options, start, study.mechanism, view.conditions);
    view.names = name_coefficients(study.mechanism, view.conditions, list_symbols(space), nearby);
  }
  view.numbers = study.free_numbers;
  view.occurring = list_occurring(space, view.conditions, derive);
  judge(view, assembled_at(study.mechanism, start), study.trajectories, options);
  if (!view.residuals.allFinite())
    answer.refusal = {"overflow",
                      has_mass(study.mechanism)
                          ? "numbers overflow: what the conditions leave is larger than can be computed with"
                          : no_mass};
  return answer;
}

Refusal refusal_of(const DesignReport& report) {
  const Conditions& conditions = report.outcome.conditions;
  if (report.outcome.status != DesignStatus::unsolved) return {};
  // with conditions at hand it is what was to be made small that has no value
  return {conditions.status == ConditionsStatus::done ? "no-value" : name_of(conditions.status),
          report.outcome.reason.empty() ? conditions.reason : report.outcome.reason};
}

namespace {

/// The design as its own spec: how a reader of the file that -o writes would know its lengths.
std::vector<Symbol> symbols_of_design(const Study& study, const std::string& balanced, const Mechanism& mechanism,
                                      std::vector<std::string>& notes) {
  try {
    return list_symbols(read_design_space(balanced, study.spec_file));
  } catch (const SpecError& error) {
    notes.push_back("the designed spec needs a change before it can be read: " + error.brief());
    return own_symbols(mechanism);
  }
}

ConditionsView view_conditions(const DesignStudyOptions& options, const DesignSpace& space, const std::string& balanced,
                               DesignReport& report) {
  const DesignOutcome& outcome = report.outcome;
  const Mechanism& mechanism = report.study_after.mechanism;
  ConditionsView view;
  view.title = space.start.mechanism.name;
  view.strategy = options.modular ? "modular" : "complete";
  view.conditions = outcome.conditions;
  view.numbers = report.numbers;
  if (view.conditions.goals.empty()) {  // only a figure was asked for
    view.residuals = VectorX(0);
    return view;
  }
  const LooseSprings loose = loose_springs_of(view.conditions, mechanism);
  ConditionOptions condition_options;
  condition_options.loose_springs = loose;
  condition_options.without = options.without;
  condition_options.open_terms = view.conditions.open_terms;
  if (!space.start.trajectories.empty()) condition_options.about = space.start.trajectories.front().about;
  const auto symbols = symbols_of_design(space.start, balanced, mechanism, report.notes);
  const auto start = start_coordinates(space.start);
  const Derive derive = make_derive(view.conditions.goals, options.modular, condition_options, start);
  view.names = name_coefficients(
      mechanism, view.conditions, symbols,
      make_derive_nearby(derive, options.modular, condition_options, start, mechanism, view.conditions));
  view.occurring = outcome.occurring;
  view.occurring.resize(static_cast<std::size_t>(view.conditions.matrix.rows()));
  judge(view, assembled_at(mechanism, start_coordinates(space.start)), report.study_after.trajectories,
        condition_options);
  return view;
}

}  // namespace

DesignView make_view(const DesignStudyOptions& options, const DesignSpace& space, const std::string& balanced,
                     DesignReport report) {
  DesignView view;
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  view.objective = objective_text(terms);
  view.objective_unit = objective_unit(terms, space.start.mechanism);
  view.conditions = view_conditions(options, space, balanced, report);
  const Eigen::Index rows = view.conditions.conditions.matrix.rows();
  view.residuals_before = report.outcome.before.size() == rows
                              ? report.outcome.before
                              : VectorX::Constant(rows, std::numeric_limits<double>::quiet_NaN());
  view.seconds = options.search.seconds;
  view.warnings = space.start.warnings;
  view.report = std::move(report);
  return view;
}

}  // namespace balance
