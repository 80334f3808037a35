#include "balance/synthesis/design/load_case_study.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/case_objective.hpp"
#include "balance/synthesis/design/condition_dependence.hpp"
#include "balance/synthesis/design/required_motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>

namespace balance {

// How numbers follow the load.

/// The law of adapted numbers, or a table of them, with what it takes to move what they move.
class AdaptiveStudy {
 public:
  /// @param space, options, judge must outlive the study
  /// @param x the free numbers at the spec's own load; those that are not adapted are for all loads
  /// @param found values of the adapted numbers per case
  AdaptiveStudy(const DesignSpace& space, const DesignStudyOptions& options, const LoadCaseEvaluator& judge,
                const VectorX& x, const MatrixX& found);

  /// Adapted numbers at a load: by the law where it keeps their bounds, else solved for.
  /// @param near where to start from
  VectorX adapted_values(const VectorX& loads, const VectorX& near) const;
  /// The same with the other free numbers.
  VectorX variable_values(const VectorX& loads) const;
  /// Everything but `fixed`.
  AdaptiveReport report() const;

 private:
  void find_law();
  AdaptedTable table() const;
  void find_value_ranges(AdaptiveReport& report) const;
  std::optional<double> adjustment_work() const;
  VectorX insert_adapted(const VectorX& adapted) const;
  bool is_within_bounds(const VectorX& adapted) const;
  const LoadCases& loads() const { return space_.start.design.cases; }

  const DesignSpace& space_;
  const DesignStudyOptions& options_;
  const LoadCaseEvaluator& judge_;
  VectorX x_;
  MatrixX found_;
  VectorX lower_, upper_;  ///< of the loads
  std::optional<AdaptiveLaw> law_;
};

namespace {

constexpr int adapted_table_size = 17;
/// What leaves a bound by this part of its interval does so by round-off.
constexpr double adapted_bound_tolerance = 1e-9;

}  // namespace

AdaptiveStudy::AdaptiveStudy(const DesignSpace& space, const DesignStudyOptions& options,
                             const LoadCaseEvaluator& judge, const VectorX& x, const MatrixX& found)
    : space_(space),
      options_(options),
      judge_(judge),
      x_(x),
      found_(found),
      lower_(-row_maxima(-loads().values.transpose())),
      upper_(row_maxima(loads().values.transpose())) {
  find_law();
  x_ = variable_values(VectorX(nominal_load(space)));
}

VectorX AdaptiveStudy::insert_adapted(const VectorX& adapted) const {
  VectorX x = x_;
  x(loads().adapted) = adapted;
  return x;
}

bool AdaptiveStudy::is_within_bounds(const VectorX& adapted) const {
  for (Eigen::Index i = 0; i < adapted.size(); ++i) {
    const int which = loads().adapted[static_cast<std::size_t>(i)];
    const FreeNumber& number = space_.start.free_numbers[static_cast<std::size_t>(which)];
    const double room = adapted_bound_tolerance * (number.upper - number.lower);
    if (adapted[i] < number.lower - room || adapted[i] > number.upper + room) return false;
  }
  return true;
}

/// The loads that vary become numbers of the problem, behind the adapted ones.
void AdaptiveStudy::find_law() {
  const VectorX anchor = found_.colwise().mean();
  DesignSpace law = space_.fix_others(insert_adapted(anchor), loads().adapted);
  law.start.design.minimize.clear();
  std::vector<int> varied;
  for (std::size_t k = 0; k < loads().numbers.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const LoadParameter& number = loads().numbers[k];
    law.inputs[static_cast<std::size_t>(number.input)] = lower_[i];
    if (!(lower_[i] < upper_[i])) continue;
    varied.push_back(static_cast<int>(k));
    law.start.free_numbers.push_back(
        {.key_path = number.path, .lower = lower_[i], .upper = upper_[i], .start = (lower_[i] + upper_[i]) / 2});
    law.free_inputs.push_back(number.input);
  }
  law.start = law.study_at(law.start_values());
  DesignStudyOptions plain = options_;
  plain.minimize.clear();
  const auto goals = plain.goals.empty() ? space_.start.design.goals : plain.goals;
  if (goals.empty()) return;
  law_ = find_adaptive_law(make_design_problem(law, plain), anchor);
  if (!law_) return;
  for (AdaptiveLaw::Term& term : law_->terms) {
    std::vector<int> powers(loads().numbers.size(), 0);
    for (std::size_t k = 0; k < varied.size(); ++k) powers[static_cast<std::size_t>(varied[k])] = term.powers[k];
    term.powers = std::move(powers);
  }
}

VectorX AdaptiveStudy::adapted_values(const VectorX& loads_there, const VectorX& near) const {
  if (law_ && is_within_bounds(law_->evaluate(loads_there))) return law_->evaluate(loads_there);
  const DesignSpace part = at_load(space_, loads_there).fix_others(insert_adapted(near), loads().adapted);
  DesignProblem problem = make_design_problem(part, options_);
  const DesignOutcome outcome = solve_design(problem);
  return outcome.status == DesignStatus::unsolved ? near : outcome.x;
}

VectorX AdaptiveStudy::variable_values(const VectorX& loads_there) const {
  const VectorX width = (upper_ - lower_).cwiseMax(std::numeric_limits<double>::min());
  const Eigen::Index nearest =
      min_index(((loads().values.rowwise() - loads_there.transpose()).array().rowwise() / width.transpose().array())
                    .matrix()
                    .rowwise()
                    .norm());
  const VectorX near = found_.row(nearest);
  if (!law_ && loads().values.row(nearest).transpose() == loads_there) return insert_adapted(near);
  return insert_adapted(adapted_values(loads_there, near));
}

/// One number of the load: evenly over its range; several: the cases.
AdaptedTable AdaptiveStudy::table() const {
  AdaptedTable table;
  const auto add = [&](const VectorX& there, const VectorX& near) {
    table.loads.push_back(there);
    table.values.push_back(adapted_values(there, near));
    table.residuals.push_back(
        judge_.max_residual(at_load(space_, there).study_at(insert_adapted(table.values.back()))));
  };
  if (lower_.size() > 1) {
    for (Eigen::Index k = 0; k < loads().size(); ++k) add(loads().values.row(k), found_.row(k));
    return table;
  }
  VectorX near = found_.row(min_index(loads().values.col(0)));
  std::vector<double> knots;
  for (int k = 0; k < adapted_table_size; ++k) {
    knots.push_back(lower_[0] + (upper_[0] - lower_[0]) * k / (adapted_table_size - 1));
    add(VectorX::Constant(1, knots.back()), near);
    near = table.values.back();
  }
  Samples rows(adapted_table_size, near.size());
  for (int k = 0; k < adapted_table_size; ++k) rows.row(k) = table.values[static_cast<std::size_t>(k)].transpose();
  const CubicSpline spline(knots, rows, SplineEnd::not_a_knot);
  VectorX value = near, first_slope = near, second = near;
  for (int k = 0; k + 1 < adapted_table_size; ++k) {
    const double middle = (knots[static_cast<std::size_t>(k)] + knots[static_cast<std::size_t>(k) + 1]) / 2;
    spline.at(middle, value, first_slope, second);
    const Study there = at_load(space_, VectorX::Constant(1, middle)).study_at(insert_adapted(value));
    table.midpoint_residual = std::max(table.midpoint_residual, judge_.max_residual(there));
  }
  return table;
}

/// Over a grid of the loads, which has the corners in it: exact for laws without powers of one load.
void AdaptiveStudy::find_value_ranges(AdaptiveReport& report) const {
  const auto count = static_cast<Eigen::Index>(loads().adapted.size());
  report.min_values = VectorX::Constant(count, std::numeric_limits<double>::infinity());
  report.max_values = -report.min_values;
  const auto add = [&](const VectorX& a) {
    report.min_values = report.min_values.cwiseMin(a);
    report.max_values = report.max_values.cwiseMax(a);
  };
  if (!law_)
    for (const VectorX& a : report.table.values) add(a);
  constexpr int max_load_grid_points = 20'000;
  const auto n = static_cast<int>(lower_.size());
  const int steps = std::clamp(static_cast<int>(elementary::pow(max_load_grid_points, 1.0 / n)) - 1, 1, 200);
  long points = 1;
  for (int k = 0; k < n; ++k) points *= steps + 1;
  for (long p = 0; law_ && p < points; ++p) {
    VectorX load = lower_;
    long rest = p;
    for (int k = 0; k < n; ++k, rest /= steps + 1)
      load[k] += (upper_[k] - lower_[k]) * static_cast<double>(rest % (steps + 1)) / steps;
    add(law_->evaluate(load));
  }
  report.is_within_bounds = is_within_bounds(report.min_values) && is_within_bounds(report.max_values);
}

/// The load stays the spec's own meanwhile: what it gains is not what moving costs.
std::optional<double> AdaptiveStudy::adjustment_work() const {
  const Study from = space_.study_at(variable_values(lower_)), to = space_.study_at(variable_values(upper_));
  if (from.trajectories.empty()) return std::nullopt;
  const auto masses = [](const Mechanism& mechanism) {
    VectorX all(
        static_cast<Eigen::Index>(mechanism.attachments.size() + mechanism.discs.size() + mechanism.bodies.size()));
    Eigen::Index k = 0;
    for (const auto& one : mechanism.attachments) all[k++] = one.mass;
    for (const auto& one : mechanism.discs) all[k++] = one.mass;
    for (const auto& one : mechanism.bodies) all[k++] = one.mass;
    return all;
  };
  const VectorX before = masses(from.mechanism), after = masses(to.mechanism);
  if ((before - after).norm() > 1e-12 * before.norm()) return std::nullopt;
  double energy[2];
  for (const Study* study : {&from, &to}) {
    Trajectory trajectory = study->trajectories.front();
    trajectory.samples = 2;
    try {
      const RunResult result = simulate(study->mechanism, trajectory);
      if (result.potential_energy.rows() == 0) return std::nullopt;
      energy[study == &to] = result.potential_energy(0, 0);
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // there is no such motion
    }
  }
  return energy[1] - energy[0];
}

AdaptiveReport AdaptiveStudy::report() const {
  AdaptiveReport report;
  report.numbers = loads().adapted;
  report.law = law_;
  if (!law_) report.table = table();
  find_value_ranges(report);
  report.adjustment_work = adjustment_work();
  return report;
}

namespace {

Mechanism assembled_mechanism(const Study& study) { return assembled_at(study.mechanism, start_coordinates(study)); }

/// What the weights and springs of a mechanism of this size leave of zero [N m].
double static_effort_round_off(const Mechanism& mechanism) {
  constexpr double static_effort_tolerance = 1e-13;
  const double length = characteristic_length(mechanism);
  double force = total_mass(mechanism) * mechanism.gravity.norm();
  for (const Spring& spring : mechanism.springs) {
    const bool turns = spring.is_joint_spring() &&
                       mechanism.coordinates[static_cast<std::size_t>(spring.coordinate)].kind == CoordinateKind::angle;
    force += turns ? spring.stiffness / length : spring.stiffness * length;
  }
  return static_effort_tolerance * force * length;
}

/// Efforts of everything that weighs, pulls or pushes, over random poses.
std::vector<PeakEffort> static_efforts(const Mechanism& mechanism, const ConditionOptions& given) {
  ConditionOptions options = given;
  options.loose_springs.clear();
  Conditions all;  // no row: nothing takes anything away
  all.parameters = list_terms(mechanism);
  all.known_term_values = known_term_values(mechanism);
  all.matrix.resize(0, static_cast<Eigen::Index>(all.parameters.size()));
  UnbalanceableElement everything{ParameterOwner::body, 0, "", {}, {}};
  everything.terms.resize(all.parameters.size());
  std::iota(everything.terms.begin(), everything.terms.end(), 0);
  std::vector<PeakEffort> efforts = find_peak_static_efforts(mechanism, all, everything, options);
  std::erase_if(efforts,
                [least = static_effort_round_off(mechanism)](const PeakEffort& one) { return one.magnitude <= least; });
  return efforts;
}

LoadCaseRun run_load_case(const Mechanism& mechanism, const Trajectory& trajectory) {
  LoadCaseRun run;
  run.trajectory = trajectory.name;
  try {
    RunResult result = simulate(mechanism, trajectory);
    run.outcome = std::move(result.outcome);
    for (Metric& metric : result.metrics)
      if (effort_array_name(metric.quantity).starts_with("torque") || metric.quantity.starts_with("shaking_"))
        run.metrics.push_back(std::move(metric));
  } catch (const std::invalid_argument& error) {
    run.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
  }
  return run;
}

}  // namespace

Conditions LoadCaseEvaluator::derive_conditions(const Study& loaded) const {
  return derive_conditions(assembled_mechanism(loaded));
}

Conditions LoadCaseEvaluator::derive_conditions(const Mechanism& mechanism) const {
  if (!problem_.goals.empty()) return problem_.derive_conditions(mechanism, problem_.goals, problem_.options);
  Conditions undefined_deviation;
  undefined_deviation.status = ConditionsStatus::done;
  undefined_deviation.parameters = list_terms(mechanism);
  undefined_deviation.matrix.resize(0, static_cast<Eigen::Index>(undefined_deviation.parameters.size()));
  return undefined_deviation;
}

double LoadCaseEvaluator::max_residual(const Study& loaded) const {
  const Conditions found = derive_conditions(loaded);
  if (found.status != ConditionsStatus::done) return std::numeric_limits<double>::quiet_NaN();
  if (found.matrix.rows() == 0) return 0;
  return max_abs(scaled_residuals(found, term_values(loaded.mechanism, problem_.options.loose_springs)));
}

LoadCaseReport LoadCaseEvaluator::report(const DesignSpace& space, const VectorX& loads, const VectorX& x) const {
  const Study loaded = space.study_at(x);
  LoadCaseReport report;
  report.loads = loads;
  report.x = x;
  report.residual = max_residual(loaded);
  report.static_efforts = static_efforts(assembled_mechanism(loaded), problem_.options);
  if (!trajectories_) return report;
  for (const Trajectory& trajectory : loaded.trajectories)
    report.runs.push_back(run_load_case(loaded.mechanism, trajectory));
  return report;
}

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
