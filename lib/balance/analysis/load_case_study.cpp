#include "balance/analysis/load_case_study.hpp"

#include "balance/analysis/adaptive_study.hpp"
#include "balance/analysis/case_objective.hpp"
#include "balance/analysis/duties.hpp"
#include "balance/analysis/finite_trial.hpp"
#include "balance/analysis/occurrence.hpp"
#include "balance/analysis/start_pose.hpp"
#include "balance/model/side_by_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace balance {

namespace {

std::string case_label(const std::string& name, std::size_t k) { return fmt::format("{} (case {})", name, k + 1); }

/// The same with names that proofs can tell apart.
Mechanism label_elements(Mechanism mechanism, std::size_t k) {
  const auto label = [k](auto& list, std::size_t first) {
    for (std::size_t i = first; i < list.size(); ++i) list[i].name = case_label(list[i].name, k);
  };
  label(mechanism.bodies, 1);
  label(mechanism.attachments, 0);
  label(mechanism.discs, 0);
  label(mechanism.loads, 0);
  label(mechanism.springs, 0);
  return mechanism;
}

void check_case_problem(const DesignSpace& space, const DesignProblem& problem) {
  for (const Goal& goal : problem.goals)
    if (goal.kind == GoalKind::proportional || goal.kind == GoalKind::affine)
      throw std::invalid_argument(
          fmt::format("the goal {} knows no load cases: every load has its own centre of mass", goal_name(goal)));
  if (problem.is_modular) throw std::invalid_argument("the modular strategy knows no load cases");
  const Vector3 gravity = space.start.mechanism.gravity;
  for (Eigen::Index k = 0; k < space.start.design.cases.size(); ++k)
    if (at_load(space, space.start.design.cases.values.row(k)).start.mechanism.gravity != gravity)
      throw std::invalid_argument("load cases differ in what a mechanism carries, not in gravity");
}

/// Goals, conditions and search of a problem, without numbers and figures.
DesignProblem strip_to_conditions(const DesignProblem& own) {
  DesignProblem question;
  question.goals = own.goals;
  question.options = own.options;
  question.derive_conditions = own.derive_conditions;
  question.is_modular = own.is_modular;
  question.search = own.search;
  question.on_progress = own.on_progress;
  question.cardinality_constraints = own.cardinality_constraints;
  return question;
}

/// Where the spec's free numbers stand among those of all cases.
std::vector<int> map_to_all_cases(const CaseSpace& cases, const std::vector<int>& numbers) {
  std::vector<int> all;
  for (const auto& position : cases.variable_index)
    for (const int i : numbers)
      if (const int at = position[static_cast<std::size_t>(i)]; std::find(all.begin(), all.end(), at) == all.end())
        all.push_back(at);
  return all;
}

/// Free numbers of the spec that may still change, for those of all cases.
void map_solution_set(const CaseSpace& cases, SolutionSet& freedom) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < cases.variable_index.front().size(); ++i)
    for (const auto& position : cases.variable_index)
      if (std::find(freedom.free_variables.begin(), freedom.free_variables.end(), position[i]) !=
          freedom.free_variables.end()) {
        numbers.push_back(static_cast<int>(i));
        break;
      }
  freedom.free_variables = std::move(numbers);
}

/// Conditions, residuals and open rows at the spec's own load.
void evaluate_nominal_conditions(const DesignSpace& space, const LoadCaseEvaluator& judge, const FreeSprings& loose,
                                 DesignOutcome& outcome) {
  const Study after = space.study_at(outcome.x);
  outcome.conditions = judge.derive_conditions(after);
  outcome.unmet_fixed_conditions.clear();
  outcome.unmet_conditions.clear();
  outcome.condition_variables.clear();
  if (outcome.certificate) outcome.certificate->combination = outcome.certificate->coefficients = VectorX(0);
  if (outcome.conditions.status != ConditionsStatus::done) {
    outcome.status = DesignStatus::unsolved;
    outcome.reason = outcome.conditions.reason;
    return;
  }
  outcome.residuals_before = scaled_residuals(outcome.conditions, term_values(space.start.mechanism, loose));
  outcome.residuals_after = scaled_residuals(outcome.conditions, term_values(after.mechanism, loose));
  for (int row = 0; row < outcome.residuals_after.size(); ++row)
    if (!(std::abs(outcome.residuals_after[row]) <= condition_tolerance)) outcome.unmet_conditions.push_back(row);
  outcome.condition_variables = probe_condition_variables(
      space, outcome.conditions, [&](const Mechanism& m) { return judge.derive_conditions(m); }, loose);
}

/// Values of the adapted numbers per case.
MatrixX adapted_values(const CaseSpace& cases, const std::vector<int>& adapted, const VectorX& x) {
  MatrixX found(static_cast<Eigen::Index>(cases.cases.size()), static_cast<Eigen::Index>(adapted.size()));
  for (std::size_t k = 0; k < cases.cases.size(); ++k)
    found.row(static_cast<Eigen::Index>(k)) = cases.values(k, x)(adapted).transpose();
  return found;
}

template <class Together>
DesignProblem make_case_problem(const DesignSpace& space, const DesignStudyOptions& options,
                                const DesignProblem& question, const std::shared_ptr<const Together>& together) {
  DesignProblem problem = question;
  problem.options.loose_springs.clear();
  check_case_problem(space, problem);
  const CaseSpace& cases = together->space();
  for (const std::string& name : options.excluded)  // sections and friction are called so in all cases
    for (std::size_t k = 0; k < cases.cases.size(); ++k) problem.options.excluded.push_back(case_label(name, k));
  for (const FreeNumber& number : cases.numbers)
    problem.variables.push_back({number.key_path, number.lower, number.upper, number.start, number.discrete_values});
  for (CardinalityConstraint& choice : problem.cardinality_constraints)
    for (OptionalElement& element : choice.elements) element.variables = map_to_all_cases(cases, element.variables);
  problem.build_mechanism = [together](const VectorX& x) { return together->mechanism(x); };
  problem.invalidity_reason = [together](const VectorX& x) { return together->invalidity_reason(x); };
  problem.infeasibility_reason = [together](const VectorX& x) { return together->obstacle(x); };
  problem.options.loose_springs = find_loose_springs(problem);
  const std::vector<FigureLimit>& limits = space.start.design.subject_to;
  problem.limits = build_case_limits(cases, limits, problem.options.loose_springs);
  problem.limits_at_geometry = [together, limits](const VectorX& x, const std::vector<int>& kept,
                                                  const FreeSprings& loose) {
    return build_case_limits(together->space().fix_others(x, kept), limits, loose);
  };
  problem.convex_limits =
      build_case_convex_limits(cases, limits, problem.options.loose_springs, problem.convex_limit_count);
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  if (terms.empty()) return problem;
  const CaseAggregation across = space.start.design.cases.aggregation;
  problem.objective = build_case_objective(cases, terms, across, problem.options.loose_springs);
  problem.convex_terms_at = build_case_convex_terms(cases, terms, across, problem.options.loose_springs);
  problem.all_convex_terms_at =
      build_case_convex_terms(cases, terms, across, problem.options.loose_springs, FigureSampling::full);
  problem.objective_at_geometry = [together, terms, across](const VectorX& x, const std::vector<int>& kept,
                                                            const FreeSprings& loose) {
    return build_case_objective(together->space().fix_others(x, kept), terms, across, loose);
  };
  return problem;
}

}  // namespace

/// What all cases ask for at once.
class LoadCaseStudy::CombinedCases {
 public:
  explicit CombinedCases(CaseSpace space) : space_(std::move(space)) {
    for (const DesignSpace& one : space_.cases) duties_.emplace_back(one.start);
  }

  Mechanism mechanism(const VectorX& x) const {
    std::vector<Mechanism> all;
    for (std::size_t k = 0; k < duties_.size(); ++k)
      all.push_back(label_elements(assembled_at(trial(k, x).mechanism, duties_[k].start_coordinates()), k));
    return disjoint_union(all);
  }
  std::string invalidity_reason(const VectorX& x) const {
    for (std::size_t k = 0; k < duties_.size(); ++k)
      if (const std::string why = find_validation_issue(trial(k, x).mechanism); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }
  std::string obstacle(const VectorX& x) const {
    for (std::size_t k = 0; k < duties_.size(); ++k)
      if (const std::string why = duties_[k].infeasibility_reason(trial(k, x)); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }
  const CaseSpace& space() const { return space_; }

 private:
  DesignInstance trial(std::size_t k, const VectorX& x) const {
    return instantiate_checked(space_.cases[k], space_.values(k, x));
  }

  CaseSpace space_;
  std::vector<RequiredMotions> duties_;
};

LoadCaseStudy::LoadCaseStudy(const DesignSpace& space, const DesignStudyOptions& options)
    : space_(space),
      options_(options),
      together_(std::make_shared<const CombinedCases>(make_case_space(space))),
      conditions_problem_(strip_to_conditions(make_design_problem(space_, options_))),
      problem_(make_case_problem(space_, options_, conditions_problem_, together_)) {}

LoadCaseStudy::~LoadCaseStudy() = default;

const CaseSpace& LoadCaseStudy::cases() const { return together_->space(); }

void LoadCaseStudy::describe(DesignReport& report) const {
  const LoadCases& loads = space_.start.design.cases;
  DesignOutcome& outcome = report.outcome;
  if (outcome.status == DesignStatus::unsolved) return;

  const VectorX whole = outcome.x;
  const LoadCaseEvaluator judge(conditions_problem_, options_.compare_trajectories);
  map_solution_set(cases(), outcome.solution_set);
  outcome.x = cases().values(0, whole);
  std::optional<AdaptiveStudy> adaptive;
  if (!loads.adapted.empty()) {
    adaptive.emplace(space_, options_, judge, outcome.x, adapted_values(cases(), loads.adapted, whole));
    outcome.x = adaptive->variable_values(nominal_load(space_)).array() + 0.0;  // a law may give −0
    report.adaptive = adaptive->report();
  }
  for (Eigen::Index k = 0; k < loads.size(); ++k) {
    const auto which = static_cast<std::size_t>(k);
    const VectorX load = loads.values.row(k);
    report.load_cases.push_back(judge.report(cases().cases[which], load, cases().values(which, whole)));
    if (adaptive) report.adaptive->fixed_design_cases.push_back(judge.report(cases().cases[which], load, outcome.x));
  }
  evaluate_nominal_conditions(space_, judge, conditions_problem_.options.loose_springs, outcome);
}

}  // namespace balance
