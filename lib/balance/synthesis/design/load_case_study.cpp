#include "balance/synthesis/design/load_case_study.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/case_conditions.hpp"
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

namespace balance::design {

// Adaptive balancing: numbers as functions of the load.

/// The law or the table of the adapted numbers, and the work needed for the adjustment.
class AdaptiveStudy {
 public:
  /// @param space, options, evaluator must outlive the study
  /// @param x the free numbers at the nominal load; those that are not adapted apply to all loads
  /// @param case_values values of the adapted numbers in each case
  AdaptiveStudy(const DesignSpace& space, const DesignStudyOptions& options, const LoadCaseEvaluator& evaluator,
                const VectorX& x, const MatrixX& case_values);

  /// Adapted numbers at a load: by the law if it satisfies their bounds, else by solving for them.
  /// @param initial_values of the search
  VectorX adapted_values(const VectorX& loads, const VectorX& initial_values) const;
  /// The same, together with the other free numbers.
  VectorX variable_values(const VectorX& loads) const;
  /// Complete except for `fixed_design_cases`.
  AdaptiveReport report() const;

 private:
  DesignSpace adapted_space(const DesignSpace& space, const VectorX& adapted) const;
  void find_law();
  AdaptedTable table() const;
  void find_value_ranges(AdaptiveReport& report) const;
  std::optional<double> adjustment_work() const;
  VectorX insert_adapted(const VectorX& adapted) const;
  bool is_within_bounds(const VectorX& adapted) const;
  const study::LoadCases& loads() const { return space_.start.design.cases; }

  const DesignSpace& space_;
  const DesignStudyOptions& options_;
  const LoadCaseEvaluator& evaluator_;
  VectorX x_;
  MatrixX case_values_;
  VectorX lower_, upper_;  ///< range of the loads
  std::optional<AdaptiveLaw> law_;
};

namespace {

constexpr int adapted_table_size = 17;
/// Violations of bounds below this are round-off, relative to the interval.
constexpr double adapted_bound_tolerance = 1e-9;

}  // namespace

AdaptiveStudy::AdaptiveStudy(const DesignSpace& space, const DesignStudyOptions& options,
                             const LoadCaseEvaluator& evaluator, const VectorX& x, const MatrixX& case_values)
    : space_(space),
      options_(options),
      evaluator_(evaluator),
      x_(x),
      case_values_(case_values),
      lower_(-numerics::row_maxima(-loads().values.transpose())),
      upper_(numerics::row_maxima(loads().values.transpose())) {
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
    const int index = loads().adapted[static_cast<std::size_t>(i)];
    const FreeNumber& number = space_.start.free_numbers[static_cast<std::size_t>(index)];
    const double tolerance = adapted_bound_tolerance * (number.upper - number.lower);
    if (adapted[i] < number.lower - tolerance || adapted[i] > number.upper + tolerance) return false;
  }
  return true;
}

/// A space in which only the adapted numbers are free; the design has made its choices.
DesignSpace AdaptiveStudy::adapted_space(const DesignSpace& space, const VectorX& adapted) const {
  DesignSpace result = space.fix_others(insert_adapted(adapted), loads().adapted);
  result.start.design.cardinality.clear();
  return result;
}

/// The varying loads become additional variables of the problem, after the adapted numbers.
void AdaptiveStudy::find_law() {
  const VectorX anchor = case_values_.colwise().mean();
  DesignSpace law_space = adapted_space(space_, anchor);
  law_space.start.design.minimize.clear();
  std::vector<int> varied;
  for (std::size_t k = 0; k < loads().numbers.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const study::LoadParameter& number = loads().numbers[k];
    law_space.inputs[static_cast<std::size_t>(number.input)] = lower_[i];
    if (!(lower_[i] < upper_[i])) continue;
    varied.push_back(static_cast<int>(k));
    law_space.start.free_numbers.push_back(
        {.key_path = number.path, .lower = lower_[i], .upper = upper_[i], .start = (lower_[i] + upper_[i]) / 2});
    law_space.free_inputs.push_back(number.input);
  }
  law_space.start = law_space.study_at(law_space.start_values());
  DesignStudyOptions law_options = options_;
  law_options.minimize.clear();
  const auto goals = law_options.goals.empty() ? space_.start.design.goals : law_options.goals;
  const auto has_sizes = [this](int i) {
    return !space_.start.free_numbers[static_cast<std::size_t>(i)].discrete_values.empty();
  };
  const bool is_between_sizes = std::any_of(loads().adapted.begin(), loads().adapted.end(), has_sizes);
  if (goals.empty() || is_between_sizes) return;
  law_ = find_adaptive_law(make_design_problem(law_space, law_options), anchor);
  if (!law_) return;
  for (AdaptiveLaw::Term& term : law_->terms) {
    std::vector<int> powers(loads().numbers.size(), 0);
    for (std::size_t k = 0; k < varied.size(); ++k) powers[static_cast<std::size_t>(varied[k])] = term.powers[k];
    term.powers = std::move(powers);
  }
}

VectorX AdaptiveStudy::adapted_values(const VectorX& load, const VectorX& initial_values) const {
  if (law_ && is_within_bounds(law_->evaluate(load))) return law_->evaluate(load);
  const DesignSpace space = adapted_space(at_load(space_, load), initial_values);
  DesignProblem problem = make_design_problem(space, options_);
  problem.is_single_pass = true;
  const DesignOutcome outcome = solve_design(problem);
  return outcome.status == DesignStatus::unsolved ? initial_values : outcome.x;
}

VectorX AdaptiveStudy::variable_values(const VectorX& load) const {
  const VectorX width = (upper_ - lower_).cwiseMax(std::numeric_limits<double>::min());
  const Eigen::Index nearest =
      numerics::min_index(((loads().values.rowwise() - load.transpose()).array().rowwise() / width.transpose().array())
                              .matrix()
                              .rowwise()
                              .norm());
  const VectorX initial_values = case_values_.row(nearest);
  if (!law_ && loads().values.row(nearest).transpose() == load) return insert_adapted(initial_values);
  return insert_adapted(adapted_values(load, initial_values));
}

/// For a single load parameter, at equidistant values; for several, at the load cases.
AdaptedTable AdaptiveStudy::table() const {
  AdaptedTable table;
  const auto add = [&](const VectorX& load, const VectorX& initial_values) {
    table.loads.push_back(load);
    table.values.push_back(adapted_values(load, initial_values));
    table.residuals.push_back(
        evaluator_.max_residual(at_load(space_, load).study_at(insert_adapted(table.values.back()))));
  };
  if (lower_.size() > 1) {
    for (Eigen::Index k = 0; k < loads().size(); ++k) add(loads().values.row(k), case_values_.row(k));
    return table;
  }
  VectorX initial_values = case_values_.row(numerics::min_index(loads().values.col(0)));
  std::vector<double> knots;
  for (int k = 0; k < adapted_table_size; ++k) {
    knots.push_back(lower_[0] + (upper_[0] - lower_[0]) * k / (adapted_table_size - 1));
    add(VectorX::Constant(1, knots.back()), initial_values);
    initial_values = table.values.back();
  }
  Samples rows(adapted_table_size, initial_values.size());
  for (int k = 0; k < adapted_table_size; ++k) rows.row(k) = table.values[static_cast<std::size_t>(k)].transpose();
  const numerics::CubicSpline spline(knots, rows, numerics::SplineEnd::not_a_knot);
  VectorX value = initial_values, first_slope = initial_values, second = initial_values;
  for (int k = 0; k + 1 < adapted_table_size; ++k) {
    const double middle = (knots[static_cast<std::size_t>(k)] + knots[static_cast<std::size_t>(k) + 1]) / 2;
    spline.at(middle, value, first_slope, second);
    const Study study = at_load(space_, VectorX::Constant(1, middle)).study_at(insert_adapted(value));
    table.midpoint_residual = std::max(table.midpoint_residual, evaluator_.max_residual(study));
  }
  return table;
}

/// Evaluates the law on a grid over the loads that includes the corners: exact for laws that are affine in each load.
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
    long remainder = p;
    for (int k = 0; k < n; ++k, remainder /= steps + 1)
      load[k] += (upper_[k] - lower_[k]) * static_cast<double>(remainder % (steps + 1)) / steps;
    add(law_->evaluate(load));
  }
  report.is_within_bounds = is_within_bounds(report.min_values) && is_within_bounds(report.max_values);
}

/// Keeps the nominal load, so that the work done on the load itself does not count.
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
      return std::nullopt;  // the motion does not exist
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

Mechanism assembled_mechanism(const Study& study) {
  return simulation::assembled_at(study.mechanism, simulation::start_coordinates(study));
}

/// Round-off of zero efforts, given the weights and springs of the mechanism [N m].
double static_effort_round_off(const Mechanism& mechanism) {
  constexpr double static_effort_tolerance = 1e-13;
  const double length = characteristic_length(mechanism);
  double force = total_mass(mechanism) * mechanism.gravity.norm();
  for (const Spring& spring : mechanism.springs) {
    const bool is_torsion_spring =
        spring.is_joint_spring() &&
        mechanism.coordinates[static_cast<std::size_t>(spring.coordinate)].kind == CoordinateKind::angle;
    force += is_torsion_spring ? spring.stiffness / length : spring.stiffness * length;
  }
  for (const ForceElement& element : mechanism.force_elements) {
    if (element.is_damper()) continue;
    const double largest = model::ForceLawOf<double>(element.table).max_force();
    const bool is_moment = element.is_in_joint() && !is_length_coordinate(mechanism, element.coordinate);
    force += is_moment ? largest / length : largest;
  }
  return static_effort_tolerance * force * length;
}

/// Efforts of all weights, springs and loads, over random poses.
std::vector<conditions::PeakEffort> static_efforts(const Mechanism& mechanism, const ConditionOptions& base_options) {
  ConditionOptions options = base_options;
  options.loose_springs.clear();
  Conditions no_conditions;  // without rows, so that nothing is balanced
  no_conditions.parameters = conditions::list_terms(mechanism);
  no_conditions.known_term_values = conditions::known_term_values(mechanism);
  no_conditions.matrix.resize(0, static_cast<Eigen::Index>(no_conditions.parameters.size()));
  conditions::UnbalanceableElement whole_mechanism{dynamics::ParameterOwner::body, 0, "", {}, {}};
  whole_mechanism.terms.resize(no_conditions.parameters.size());
  std::iota(whole_mechanism.terms.begin(), whole_mechanism.terms.end(), 0);
  std::vector<conditions::PeakEffort> efforts =
      find_peak_static_efforts(mechanism, no_conditions, whole_mechanism, options);
  std::erase_if(efforts, [round_off = static_effort_round_off(mechanism)](const conditions::PeakEffort& one) {
    return one.magnitude <= round_off;
  });
  return efforts;
}

LoadCaseRun run_load_case(const Mechanism& mechanism, const Trajectory& trajectory) {
  LoadCaseRun run;
  run.trajectory = trajectory.name;
  try {
    RunResult result = simulate(mechanism, trajectory);
    run.outcome = std::move(result.outcome);
    for (Metric& metric : result.metrics)
      if (results::effort_array_name(metric.quantity).starts_with("torque") || metric.quantity.starts_with("shaking_"))
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
  if (!problem_.goals.empty()) return problem_.model->derive_conditions(mechanism, problem_.goals, problem_.options);
  Conditions no_conditions;
  no_conditions.status = ConditionsStatus::done;
  no_conditions.parameters = conditions::list_terms(mechanism);
  no_conditions.matrix.resize(0, static_cast<Eigen::Index>(no_conditions.parameters.size()));
  return no_conditions;
}

double LoadCaseEvaluator::max_residual(const Study& loaded) const {
  const Conditions conditions = derive_conditions(loaded);
  if (conditions.status != ConditionsStatus::done) return std::numeric_limits<double>::quiet_NaN();
  if (conditions.matrix.rows() == 0) return 0;
  return numerics::max_abs(
      scaled_residuals(conditions, conditions::term_values(loaded.mechanism, problem_.options.loose_springs)));
}

LoadCaseReport LoadCaseEvaluator::report(const DesignSpace& space, const VectorX& loads, const VectorX& x) const {
  const Study loaded = space.study_at(x);
  LoadCaseReport report;
  report.loads = loads;
  report.x = x;
  report.residual = max_residual(loaded);
  report.static_efforts = static_efforts(assembled_mechanism(loaded), problem_.options);
  if (!simulates_trajectories_) return report;
  for (const Trajectory& trajectory : loaded.trajectories)
    report.runs.push_back(run_load_case(loaded.mechanism, trajectory));
  return report;
}

namespace {

std::string case_label(const std::string& name, std::size_t k) { return fmt::format("{} (case {})", name, k + 1); }

/// The same mechanism with names that are unique across the cases.
Mechanism label_elements(Mechanism mechanism, std::size_t k) {
  const auto label = [k](auto& list, std::size_t first) {
    for (std::size_t i = first; i < list.size(); ++i) list[i].name = case_label(list[i].name, k);
  };
  label(mechanism.bodies, 1);
  label(mechanism.attachments, 0);
  label(mechanism.discs, 0);
  label(mechanism.loads, 0);
  label(mechanism.springs, 0);
  label(mechanism.force_elements, 0);
  return mechanism;
}

void check_case_problem(const DesignSpace& space, const DesignProblem& problem) {
  for (const Goal& goal : problem.goals)
    if (goal.kind == GoalKind::proportional || goal.kind == GoalKind::affine)
      throw std::invalid_argument(fmt::format(
          "the goal {} does not support load cases: every load has its own centre of mass", goal_name(goal)));
  if (problem.options.speeds.depend_on_masses())
    throw std::invalid_argument(
        "speeds with the velocity of the centre of mass do not support load cases: every load has its own");
  const Vector3 gravity = space.start.mechanism.gravity;
  for (Eigen::Index k = 0; k < space.start.design.cases.size(); ++k)
    if (at_load(space, space.start.design.cases.values.row(k)).start.mechanism.gravity != gravity)
      throw std::invalid_argument("load cases may differ in what the mechanism carries, not in gravity");
  for (Eigen::Index k = 0; k < space.start.design.cases.size(); ++k)
    for (const Trajectory& motion : problem.options.motions) {
      const Study loaded = at_load(space, space.start.design.cases.values.row(k)).start;
      const Trajectory* own = study::find_by_name(loaded.trajectories, motion.name);
      if (own == nullptr ||
          collect_motion_numbers(space.start.mechanism, *own) != collect_motion_numbers(space.start.mechanism, motion))
        throw std::invalid_argument("the motion '" + motion.name +
                                    "' depends on the load: orders are goals along motions that do not");
    }
}

/// Keeps goals, conditions and search options of a problem; drops variables and figures.
DesignProblem strip_to_conditions(const DesignProblem& problem) {
  DesignProblem stripped;
  stripped.goals = problem.goals;
  stripped.options = problem.options;
  stripped.model = problem.model;
  stripped.is_modular = problem.is_modular;
  stripped.derives_anew = problem.derives_anew;
  stripped.search = problem.search;
  stripped.on_progress = problem.on_progress;
  stripped.cardinality_constraints = problem.cardinality_constraints;
  stripped.all_different = problem.all_different;
  return stripped;
}

/// Indices of free numbers of the spec among the numbers of all cases.
std::vector<int> map_to_all_cases(const CaseSpace& cases, const std::vector<int>& numbers) {
  std::vector<int> all;
  for (const auto& position : cases.variable_index)
    for (const int i : numbers)
      if (const int index = position[static_cast<std::size_t>(i)];
          std::find(all.begin(), all.end(), index) == all.end())
        all.push_back(index);
  return all;
}

/// Numbers that must differ do so in each case; if none of them follows the load, all cases have the same group.
std::vector<study::DifferentNumbers> map_to_each_case(const CaseSpace& cases,
                                                      const std::vector<study::DifferentNumbers>& groups) {
  std::vector<study::DifferentNumbers> mapped;
  for (const study::DifferentNumbers& different : groups)
    for (const auto& position : cases.variable_index) {
      study::DifferentNumbers in_case{{}, different.taken};
      for (const int number : different.numbers) in_case.numbers.push_back(position[static_cast<std::size_t>(number)]);
      if (mapped.empty() || mapped.back().numbers != in_case.numbers) mapped.push_back(std::move(in_case));
    }
  return mapped;
}

/// Maps the free variables of the solution set from the numbers of all cases back to the spec.
void map_solution_set(const CaseSpace& cases, SolutionSet& solution_set) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < cases.variable_index.front().size(); ++i)
    for (const auto& position : cases.variable_index)
      if (std::find(solution_set.free_variables.begin(), solution_set.free_variables.end(), position[i]) !=
          solution_set.free_variables.end()) {
        numbers.push_back(static_cast<int>(i));
        break;
      }
  solution_set.free_variables = std::move(numbers);
}

/// The same for the edges at which the design lies; lengths shared by all cases have one edge.
void map_edges(const CaseSpace& cases, std::vector<FeasibilityEdge>& edges) {
  std::vector<FeasibilityEdge> mapped;
  for (FeasibilityEdge& edge : edges)
    for (const auto& position : cases.variable_index)
      if (const auto at = std::find(position.begin(), position.end(), edge.variable); at != position.end()) {
        edge.variable = static_cast<int>(at - position.begin());
        mapped.push_back(std::move(edge));
        break;
      }
  edges = std::move(mapped);
}

/// Conditions, residuals and unmet conditions at the nominal load.
void evaluate_nominal_conditions(const DesignSpace& space, const LoadCaseEvaluator& evaluator,
                                 const dynamics::FreeSprings& loose, DesignOutcome& outcome) {
  const Study after = space.study_at(outcome.x);
  outcome.conditions = evaluator.derive_conditions(after);
  outcome.unmet_fixed_conditions.clear();
  outcome.unmet_conditions.clear();
  outcome.condition_variables.clear();
  if (outcome.certificate) outcome.certificate->combination = outcome.certificate->coefficients = VectorX(0);
  if (outcome.conditions.status != ConditionsStatus::done) {
    outcome.status = DesignStatus::unsolved;
    outcome.reason = outcome.conditions.reason;
    return;
  }
  outcome.residuals_before =
      scaled_residuals(outcome.conditions, conditions::term_values(space.start.mechanism, loose));
  outcome.residuals_after = scaled_residuals(outcome.conditions, conditions::term_values(after.mechanism, loose));
  for (int row = 0; row < outcome.residuals_after.size(); ++row)
    if (!(std::abs(outcome.residuals_after[row]) <= condition_tolerance)) outcome.unmet_conditions.push_back(row);
  outcome.condition_variables = probe_condition_variables(
      space, outcome.conditions, [&](const Mechanism& m) { return evaluator.derive_conditions(m); }, loose);
}

/// Values of the adapted numbers in each case.
MatrixX adapted_values(const CaseSpace& cases, const std::vector<int>& adapted, const VectorX& x) {
  MatrixX values(static_cast<Eigen::Index>(cases.cases.size()), static_cast<Eigen::Index>(adapted.size()));
  for (std::size_t k = 0; k < cases.cases.size(); ++k)
    values.row(static_cast<Eigen::Index>(k)) = cases.values(k, x)(adapted).transpose();
  return values;
}

}  // namespace

/// The design problem of all cases combined.
class LoadCaseStudy::CaseDesignModel final : public DesignModel {
 public:
  /// @param motions shared with other models; null: its own
  CaseDesignModel(CaseSpace space, std::vector<ObjectiveTerm> terms, const study::DesignRequest& design,
                  bool is_modular, std::shared_ptr<MotionCache> motions)
      : space_(std::move(space)),
        is_modular_(is_modular),
        terms_(std::move(terms)),
        limits_(design.subject_to),
        across_(design.cases.aggregation),
        motions_(motions ? std::move(motions) : std::make_shared<MotionCache>()) {
    for (const DesignSpace& one : space_.cases) required_motions_.emplace_back(one.start);
  }

  const CaseSpace& space() const { return space_; }

  /// Builds objective and limits of the problem, whose loose springs must be known.
  void build_figures(DesignProblem& problem) {
    const dynamics::FreeSprings& loose = problem.options.loose_springs;
    figures_.emplace(space_, loose);
    problem.limits = build_case_limits(space_, limits_, loose, *motions_);
    convex_limits_ = figures_->select_convex_limits(limits_);
    if (!terms_.empty()) problem.objective = build_case_objective(space_, terms_, across_, loose, *motions_);
    capabilities_ = {
        .has_convex_terms = !terms_.empty() && figures_->are_convex(terms_, across_),
        .has_affine_terms = !terms_.empty() && figures_->are_affine(terms_, across_),
        .has_convex_limits = !convex_limits_.empty(),
        .are_all_limits_convex = convex_limits_.size() == limits_.size(),
        .are_samples_complete = design::are_samples_complete(space_.cases.front().start, terms_, convex_limits_),
        .can_fix_geometry = true};
  }

  Capabilities capabilities() const override { return capabilities_; }
  Mechanism build_mechanism(const VectorX& x) const override {
    std::vector<Mechanism> all;
    for (std::size_t k = 0; k < required_motions_.size(); ++k)
      all.push_back(label_elements(
          required_motions_[k].assembled_mechanism(instance_at(k, x), space_.cases[k].assembly_mode != nullptr), k));
    return disjoint_union(all);
  }
  Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                               const ConditionOptions& options) const override {
    return is_modular_ || !options.motions.empty()
               ? derive_case_conditions(mechanism, space_.cases.front().start.mechanism, space_.cases.size(), goals,
                                        options, is_modular_)
               : balance::derive_conditions(mechanism, goals, options);
  }
  std::string invalidity_reason(const VectorX& x) const override {
    return first_reason([&](std::size_t k) { return find_validation_issue(instance_at(k, x).mechanism); });
  }
  std::string infeasibility_reason(const VectorX& x) const override {
    std::vector<VectorX> tried;  // loads seldom change the motion
    return first_reason([&](std::size_t k) -> std::string {
      const study::DesignInstance instance = instance_at(k, x);
      VectorX numbers = required_motions_[k].numbers(instance);
      if (std::find(tried.begin(), tried.end(), numbers) != tried.end()) return "";
      tried.push_back(std::move(numbers));
      return required_motions_[k].infeasibility_reason(instance);
    });
  }
  std::optional<std::vector<AffineFigure>> convex_terms(const VectorX& x, FigureSampling sampling) const override {
    return figures_->terms(terms_, across_, sampling, x, *motions_);
  }
  std::optional<std::vector<ConvexLimit>> convex_limits(const VectorX& x) const override {
    return figures_->limits(convex_limits_, x, *motions_);
  }
  Objective objective_at_geometry(const VectorX& x, const std::vector<int>& free,
                                  const dynamics::FreeSprings& loose) const override {
    return build_case_objective(space_.fix_others(x, free), terms_, across_, loose, *motions_);
  }
  std::vector<DesignLimit> limits_at_geometry(const VectorX& x, const std::vector<int>& free,
                                              const dynamics::FreeSprings& loose) const override {
    return build_case_limits(space_.fix_others(x, free), limits_, loose, *motions_);
  }

 private:
  study::DesignInstance instance_at(std::size_t k, const VectorX& x) const {
    return instantiate_checked(space_.cases[k], space_.values(k, x));
  }
  template <class Reason>
  std::string first_reason(const Reason& reason) const {
    for (std::size_t k = 0; k < required_motions_.size(); ++k)
      if (const std::string why = reason(k); !why.empty()) return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }

  CaseSpace space_;
  bool is_modular_;
  std::vector<ObjectiveTerm> terms_;
  std::vector<study::FigureLimit> limits_, convex_limits_;
  study::CaseAggregation across_;
  std::shared_ptr<MotionCache> motions_;
  std::vector<RequiredMotions> required_motions_;
  std::optional<CaseFigures> figures_;
  Capabilities capabilities_;
};

DesignProblem LoadCaseStudy::make_problem() const {
  DesignProblem problem = conditions_problem_;
  problem.options.loose_springs.clear();
  check_case_problem(space_, problem);
  if (!problem.options.motions.empty()) problem.derives_anew = true;
  const CaseSpace& cases = case_model_->space();
  for (const std::string& name : options_.excluded)  // sections and friction have the same names in all cases
    for (std::size_t k = 0; k < cases.cases.size(); ++k) problem.options.excluded.push_back(case_label(name, k));
  problem.options.speeds = problem.options.speeds.repeat(space_.start.mechanism, static_cast<int>(cases.cases.size()));
  problem.variables = list_design_variables(cases.numbers);
  for (CardinalityConstraint& choice : problem.cardinality_constraints)
    for (OptionalElement& element : choice.elements) {
      element.variables = map_to_all_cases(cases, element.variables);
      element.own_variables = map_to_all_cases(cases, element.own_variables);
    }
  problem.all_different = map_to_each_case(cases, problem.all_different);
  problem.model = case_model_;
  problem.options.loose_springs = find_loose_springs(problem);
  case_model_->build_figures(problem);
  return problem;
}

LoadCaseStudy::LoadCaseStudy(const DesignSpace& space, const DesignStudyOptions& options)
    : space_(space),
      options_(options),
      case_model_(std::make_shared<CaseDesignModel>(
          make_case_space(space), options.minimize.empty() ? space.start.design.minimize : options.minimize,
          space.start.design, options.is_modular, options.motions)),
      conditions_problem_(strip_to_conditions(make_design_problem(space_, options_))),
      problem_(make_problem()) {}

LoadCaseStudy::~LoadCaseStudy() = default;

const CaseSpace& LoadCaseStudy::cases() const { return case_model_->space(); }

void LoadCaseStudy::describe(DesignReport& report) const {
  const study::LoadCases& loads = space_.start.design.cases;
  DesignOutcome& outcome = report.outcome;
  if (outcome.status == DesignStatus::unsolved) return;

  const VectorX all_values = outcome.x;
  const LoadCaseEvaluator evaluator(conditions_problem_, options_.compare_trajectories);
  map_solution_set(cases(), outcome.solution_set);
  map_edges(cases(), outcome.edges);
  outcome.x = cases().values(0, all_values);
  std::optional<AdaptiveStudy> adaptive;
  if (!loads.adapted.empty()) {
    adaptive.emplace(space_, options_, evaluator, outcome.x, adapted_values(cases(), loads.adapted, all_values));
    outcome.x = adaptive->variable_values(nominal_load(space_)).array() + 0.0;  // a law may yield −0
    report.adaptive = adaptive->report();
  }
  for (Eigen::Index k = 0; k < loads.size(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const VectorX load = loads.values.row(k);
    report.load_cases.push_back(evaluator.report(cases().cases[index], load, cases().values(index, all_values)));
    if (adaptive)
      report.adaptive->fixed_design_cases.push_back(evaluator.report(cases().cases[index], load, outcome.x));
  }
  evaluate_nominal_conditions(space_, evaluator, conditions_problem_.options.loose_springs, outcome);
}

}  // namespace balance::design
