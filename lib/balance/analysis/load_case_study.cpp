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

std::string in_case(const std::string& name, std::size_t k) { return fmt::format("{} (case {})", name, k + 1); }

/// The same with names that proofs can tell apart.
Mechanism labelled(Mechanism mechanism, std::size_t k) {
  const auto label = [k](auto& list, std::size_t first) {
    for (std::size_t i = first; i < list.size(); ++i) list[i].name = in_case(list[i].name, k);
  };
  label(mechanism.bodies, 1);
  label(mechanism.attachments, 0);
  label(mechanism.discs, 0);
  label(mechanism.loads, 0);
  label(mechanism.springs, 0);
  return mechanism;
}

void check(const DesignSpace& space, const DesignProblem& problem) {
  for (const Goal& goal : problem.goals)
    if (goal.kind == GoalKind::proportional || goal.kind == GoalKind::affine)
      throw std::invalid_argument(
          fmt::format("the goal {} knows no load cases: every load has its own centre of mass", name_of(goal)));
  if (problem.modular) throw std::invalid_argument("the modular strategy knows no load cases");
  const Vector3 gravity = space.start.mechanism.gravity;
  for (Eigen::Index k = 0; k < space.start.design.cases.size(); ++k)
    if (at_load(space, space.start.design.cases.values.row(k)).start.mechanism.gravity != gravity)
      throw std::invalid_argument("load cases differ in what a mechanism carries, not in gravity");
}

/// Goals, conditions and search of a problem, without numbers and figures.
DesignProblem question_of(const DesignProblem& own) {
  DesignProblem question;
  question.goals = own.goals;
  question.options = own.options;
  question.derive = own.derive;
  question.modular = own.modular;
  question.search = own.search;
  question.watch = own.watch;
  question.choices = own.choices;
  return question;
}

/// Where the spec's free numbers stand among those of all cases.
std::vector<int> in_all_cases(const CaseSpace& cases, const std::vector<int>& numbers) {
  std::vector<int> all;
  for (const auto& position : cases.position)
    for (const int i : numbers)
      if (const int at = position[static_cast<std::size_t>(i)]; std::find(all.begin(), all.end(), at) == all.end())
        all.push_back(at);
  return all;
}

/// Free numbers of the spec that may still change, for those of all cases.
void own_freedom(const CaseSpace& cases, Freedom& freedom) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < cases.position.front().size(); ++i)
    for (const auto& position : cases.position)
      if (std::find(freedom.numbers.begin(), freedom.numbers.end(), position[i]) != freedom.numbers.end()) {
        numbers.push_back(static_cast<int>(i));
        break;
      }
  freedom.numbers = std::move(numbers);
}

/// Conditions, residuals and open rows at the spec's own load.
void own_conditions(const DesignSpace& space, const LoadJudge& judge, const LooseSprings& loose,
                    DesignOutcome& outcome) {
  const Study after = space.at(outcome.x);
  outcome.conditions = judge.conditions(after);
  outcome.unmet_fixed.clear();
  outcome.open.clear();
  outcome.occurring.clear();
  if (outcome.proof) outcome.proof->combination = outcome.proof->coefficients = VectorX(0);
  if (outcome.conditions.status != ConditionsStatus::done) {
    outcome.status = DesignStatus::unsolved;
    outcome.reason = outcome.conditions.reason;
    return;
  }
  outcome.before = scaled_residuals(outcome.conditions, term_values(space.start.mechanism, loose));
  outcome.after = scaled_residuals(outcome.conditions, term_values(after.mechanism, loose));
  for (int row = 0; row < outcome.after.size(); ++row)
    if (!(std::abs(outcome.after[row]) <= met)) outcome.open.push_back(row);
  outcome.occurring = list_occurring(
      space, outcome.conditions, [&](const Mechanism& m) { return judge.conditions(m); }, loose);
}

/// Values of the adapted numbers per case.
MatrixX adapted_values(const CaseSpace& cases, const std::vector<int>& adapted, const VectorX& x) {
  MatrixX found(static_cast<Eigen::Index>(cases.cases.size()), static_cast<Eigen::Index>(adapted.size()));
  for (std::size_t k = 0; k < cases.cases.size(); ++k)
    found.row(static_cast<Eigen::Index>(k)) = cases.values(k, x)(adapted).transpose();
  return found;
}

template <class Together>
DesignProblem state_cases(const DesignSpace& space, const DesignStudyOptions& options, const DesignProblem& question,
                          const std::shared_ptr<const Together>& together) {
  DesignProblem problem = question;
  problem.options.loose_springs.clear();
  check(space, problem);
  const CaseSpace& cases = together->space();
  for (const std::string& name : options.without)  // sections and friction are called so in all cases
    for (std::size_t k = 0; k < cases.cases.size(); ++k) problem.options.without.push_back(in_case(name, k));
  for (const FreeNumber& number : cases.numbers)
    problem.variables.push_back({number.path, number.lower, number.upper, number.start, number.sizes});
  for (Choice& choice : problem.choices)
    for (OptionalElement& element : choice.elements) element.numbers = in_all_cases(cases, element.numbers);
  problem.mechanism_at = [together](const VectorX& x) { return together->mechanism(x); };
  problem.fault = [together](const VectorX& x) { return together->fault(x); };
  problem.obstacle = [together](const VectorX& x) { return together->obstacle(x); };
  problem.options.loose_springs = find_loose_springs(problem);
  const std::vector<FigureLimit>& limits = space.start.design.subject_to;
  problem.limits = build_case_limits(cases, limits, problem.options.loose_springs);
  problem.limits_at = [together, limits](const VectorX& x, const std::vector<int>& kept, const LooseSprings& loose) {
    return build_case_limits(together->space().held(x, kept), limits, loose);
  };
  problem.bounded_at = build_case_bounded(cases, limits, problem.options.loose_springs, problem.bounded);
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  if (terms.empty()) return problem;
  const AcrossCases across = space.start.design.cases.across;
  problem.objective = build_case_objective(cases, terms, across, problem.options.loose_springs);
  problem.figures_at = build_case_figures(cases, terms, across, problem.options.loose_springs);
  problem.whole_figures_at =
      build_case_figures(cases, terms, across, problem.options.loose_springs, FigureSamples::all);
  problem.objective_at = [together, terms, across](const VectorX& x, const std::vector<int>& kept,
                                                   const LooseSprings& loose) {
    return build_case_objective(together->space().held(x, kept), terms, across, loose);
  };
  return problem;
}

}  // namespace

/// What all cases ask for at once.
class LoadCaseStudy::Together {
 public:
  explicit Together(CaseSpace space) : space_(std::move(space)) {
    for (const DesignSpace& one : space_.cases) duties_.emplace_back(one.start);
  }

  Mechanism mechanism(const VectorX& x) const {
    std::vector<Mechanism> all;
    for (std::size_t k = 0; k < duties_.size(); ++k)
      all.push_back(labelled(assembled_at(trial(k, x).mechanism, duties_[k].coordinates()), k));
    return side_by_side(all);
  }
  std::string fault(const VectorX& x) const {
    for (std::size_t k = 0; k < duties_.size(); ++k)
      if (const std::string why = first_fault(trial(k, x).mechanism); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }
  std::string obstacle(const VectorX& x) const {
    for (std::size_t k = 0; k < duties_.size(); ++k)
      if (const std::string why = duties_[k].obstacle(trial(k, x)); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }
  const CaseSpace& space() const { return space_; }

 private:
  Trial trial(std::size_t k, const VectorX& x) const { return finite_trial(space_.cases[k], space_.values(k, x)); }

  CaseSpace space_;
  std::vector<Duties> duties_;
};

LoadCaseStudy::LoadCaseStudy(const DesignSpace& space, const DesignStudyOptions& options)
    : space_(space),
      options_(options),
      together_(std::make_shared<const Together>(case_space(space))),
      question_(question_of(state_problem(space_, options_))),
      problem_(state_cases(space_, options_, question_, together_)) {}

LoadCaseStudy::~LoadCaseStudy() = default;

const CaseSpace& LoadCaseStudy::cases() const { return together_->space(); }

void LoadCaseStudy::describe(DesignReport& report) const {
  const LoadCases& loads = space_.start.design.cases;
  DesignOutcome& outcome = report.outcome;
  if (outcome.status == DesignStatus::unsolved) return;

  const VectorX whole = outcome.x;
  const LoadJudge judge(question_, options_.trajectories);
  own_freedom(cases(), outcome.freedom);
  outcome.x = cases().values(0, whole);
  std::optional<AdaptiveStudy> adaptive;
  if (!loads.adapted.empty()) {
    adaptive.emplace(space_, options_, judge, outcome.x, adapted_values(cases(), loads.adapted, whole));
    outcome.x = adaptive->all_at(own_load(space_)).array() + 0.0;  // a law may give −0
    report.adaptive = adaptive->report();
  }
  for (Eigen::Index k = 0; k < loads.size(); ++k) {
    const auto which = static_cast<std::size_t>(k);
    const VectorX load = loads.values.row(k);
    report.load_cases.push_back(judge.report(cases().cases[which], load, cases().values(which, whole)));
    if (adaptive) report.adaptive->fixed.push_back(judge.report(cases().cases[which], load, outcome.x));
  }
  own_conditions(space_, judge, question_.options.loose_springs, outcome);
}

}  // namespace balance
