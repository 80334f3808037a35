#include "balance/synthesis/design/design_study.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/study/different_numbers.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/com_tool_map.hpp"
#include "balance/synthesis/conditions/modular_conditions.hpp"
#include "balance/synthesis/design/assembly_continuation.hpp"
#include "balance/synthesis/design/catalogue_search.hpp"
#include "balance/synthesis/design/length_bound_search.hpp"
#include "balance/synthesis/design/load_case_study.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/optional_elements.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

namespace balance::design {

namespace {

/// Mass of a mechanism, and the part that was added for balancing.
struct MassSummary {
  double mass = 0, inertia = 0, added_mass = 0, added_inertia = 0;
};

/// The design problem of a spec at its nominal load.
class SpecDesignModel final : public DesignModel {
 public:
  /// @param space must outlive this object
  /// @param motions shared with other models; null: its own
  SpecDesignModel(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, bool is_modular,
                  std::shared_ptr<MotionCache> motions)
      : space_(space),
        terms_(terms),
        is_modular_(is_modular),
        required_motions_(space.start),
        motions_(motions ? std::move(motions) : std::make_shared<MotionCache>()) {}

  /// Builds objective and limits of the problem, whose loose springs must be known.
  void build_figures(DesignProblem& problem) {
    const dynamics::FreeSprings& loose = loose_ = problem.options.loose_springs;
    const std::vector<study::FigureLimit>& limits = space_.start.design.subject_to;
    problem.limits = build_design_limits(space_, limits, space_.start_values(), loose, *motions_);
    convex_limits_ = select_convex_limits(space_, limits);
    if (!terms_.empty()) problem.objective = build_objective(space_, terms_, space_.start_values(), loose, *motions_);
    capabilities_ = {.has_convex_terms = !terms_.empty() && are_convex_in_parameters(space_, terms_),
                     .has_affine_terms = !terms_.empty() && are_statistics_of_affine_quantities(space_, terms_),
                     .has_convex_limits = !convex_limits_.empty(),
                     .are_all_limits_convex = convex_limits_.size() == limits.size(),
                     .are_samples_complete = are_samples_complete(space_.start, terms_, convex_limits_),
                     .can_fix_geometry = true};
  }

  Capabilities capabilities() const override { return capabilities_; }
  Mechanism build_mechanism(const VectorX& x) const override {
    return required_motions_.assembled_mechanism(instantiate_checked(space_, x), space_.assembly_mode != nullptr);
  }
  std::string invalidity_reason(const VectorX& x) const override {
    return find_validation_issue(instantiate_checked(space_, x).mechanism);
  }
  std::string infeasibility_reason(const VectorX& x) const override {
    return required_motions_.infeasibility_reason(instantiate_checked(space_, x));
  }
  Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                               const ConditionOptions& options) const override {
    return is_modular_ ? derive_modular_conditions(mechanism, goals, options)
                       : balance::derive_conditions(mechanism, goals, options);
  }
  std::optional<std::vector<AffineFigure>> convex_terms(const VectorX& x, FigureSampling sampling) const override {
    return compute_convex_terms(space_, terms_, loose_, sampling, x, *motions_);
  }
  std::optional<std::vector<ConvexLimit>> convex_limits(const VectorX& x) const override {
    return compute_convex_limits(space_, convex_limits_, loose_, x, *motions_);
  }
  Objective objective_at_geometry(const VectorX& x, const std::vector<int>& free,
                                  const dynamics::FreeSprings& loose) const override {
    return build_objective(space_.fix_others(x, free), terms_, x(free), loose, *motions_);
  }
  std::vector<DesignLimit> limits_at_geometry(const VectorX& x, const std::vector<int>& free,
                                              const dynamics::FreeSprings& loose) const override {
    return build_design_limits(space_.fix_others(x, free), space_.start.design.subject_to, x(free), loose, *motions_);
  }

 private:
  const DesignSpace& space_;
  std::vector<ObjectiveTerm> terms_;
  bool is_modular_;
  RequiredMotions required_motions_;
  std::shared_ptr<MotionCache> motions_;
  dynamics::FreeSprings loose_;
  std::vector<study::FigureLimit> convex_limits_;
  Capabilities capabilities_;
};

VectorX bounds_of(const DesignSpace& space, double FreeNumber::*bound) {
  VectorX x(static_cast<Eigen::Index>(space.start.free_numbers.size()));
  for (std::size_t i = 0; i < space.start.free_numbers.size(); ++i)
    x[static_cast<Eigen::Index>(i)] = space.start.free_numbers[i].*bound;
  return x;
}

/// @throws std::invalid_argument if numbers that must differ have too few sizes, and no element can be left out
void check_size_shortage(const Study& study, const std::vector<CardinalityConstraint>& choices) {
  for (const study::DifferentNumbers& different : study.design.all_different) {
    study::DifferentNumbers present = different;
    for (const CardinalityConstraint& choice : choices)
      for (const OptionalElement& element : choice.elements)
        for (const auto* variables : {&element.variables, &element.own_variables})
          for (const int i : *variables) std::erase(present.numbers, i);
    const std::string shortage = find_size_shortage(present, study.free_numbers);
    if (!shortage.empty()) throw std::invalid_argument("design.all_different: " + shortage);
  }
}

/// @throws std::invalid_argument if a motion whose orders are goals depends on the free numbers
void check_goal_motions(const DesignSpace& space, const std::vector<Goal>& goals) {
  const std::vector<Trajectory> motions = study::select_goal_motions(goals, space.start.trajectories);
  if (motions.empty() || space.start.free_numbers.empty()) return;
  const study::DesignInstance low = space.instantiate(bounds_of(space, &FreeNumber::lower)),
                              high = space.instantiate(bounds_of(space, &FreeNumber::upper));
  for (const Trajectory& motion : motions) {
    const auto numbers = [&](const study::DesignInstance& instance) {
      const Trajectory* own = study::find_by_name(instance.trajectories, motion.name);
      return own == nullptr ? VectorX() : collect_motion_numbers(space.start.mechanism, *own);
    };
    if (numbers(low) != numbers(high))
      throw std::invalid_argument("the motion '" + motion.name +
                                  "' depends on free numbers: orders are goals along motions that do not");
  }
}

DesignProblem build_design_problem(const DesignSpace& space, const DesignStudyOptions& options) {
  DesignProblem problem;
  problem.variables = list_design_variables(space.start.free_numbers);
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  const auto model = std::make_shared<SpecDesignModel>(space, terms, options.is_modular, options.motions);
  problem.model = model;
  problem.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  if (!problem.goals.empty()) reject_temporary_payloads(space.start, "the goals of a design", &options.excluded);
  if (!space.start.design.cases.adapted.empty()) reject_temporary_payloads(space.start, "numbers that follow the load");
  if (problem.variables.empty()) throw std::invalid_argument("a design needs free numbers, but the spec has none");
  problem.cardinality_constraints = list_optional_elements(space);
  problem.all_different = space.start.design.all_different;
  check_size_shortage(space.start, problem.cardinality_constraints);
  if (problem.goals.empty() && terms.empty() && space.start.design.subject_to.empty())
    throw std::invalid_argument("a design needs a goal, something to minimize or limits");
  if (!space.start.trajectories.empty()) problem.options.about = space.start.trajectories.front().about;
  problem.options.motions = study::select_goal_motions(problem.goals, space.start.trajectories);
  check_goal_motions(space, problem.goals);
  problem.options.speeds = conditions::ChosenSpeeds(space.start.mechanism, space.start.design.speeds);
  if (options.is_modular && !problem.options.speeds.empty())
    throw std::invalid_argument(
        "goals in chosen speeds are those of the whole mechanism, not of the chains one by one");
  problem.is_modular = problem.derives_anew = options.is_modular;
  problem.search = options.search;
  problem.is_single_pass = options.is_single_pass;
  problem.settled_values = options.settled_values;
  problem.on_progress = options.on_progress;
  problem.options.excluded = options.excluded;
  problem.options.loose_springs = find_loose_springs(problem);
  model->build_figures(problem);
  return problem;
}

}  // namespace

std::vector<DesignVariable> list_design_variables(const std::vector<FreeNumber>& numbers) {
  std::vector<DesignVariable> variables;
  for (const FreeNumber& number : numbers)
    variables.push_back({number.key_path, number.lower, number.upper, number.start, number.discrete_values});
  return variables;
}

DesignProblem make_design_problem(const DesignSpace& space, const DesignStudyOptions& options) {
  if (has_free_rows(space.start))
    throw std::invalid_argument(
        "rows of catalogues are free, but this needs given parts: name one with 'part' under 'catalogue'");
  constexpr double min_seconds = 5;  // for the first run of each motion, even if the time for the search is shorter
  const double seconds = std::max(min_seconds, options.search.max_time);
  try {
    const Deadline deadline(seconds, [&] { return options.on_progress && !options.on_progress({0, seconds}); });
    return build_design_problem(space, options);
  } catch (const DeadlineExceeded&) {
    throw DeadlineExceeded(
        fmt::format("the motions of the spec could not be tried with its start values within {:g} s: allow more time "
                    "(--seconds, or seconds: in search:), or leave out trajectories that do not matter",
                    seconds));
  }
}

namespace {

RunResult simulate_named_trajectory(const Study& study, const std::string& name) {
  RunResult result;
  const Trajectory* trajectory = study::find_by_name(study.trajectories, name);
  if (trajectory == nullptr) return result;
  try {
    return simulate(study.mechanism, *trajectory);
  } catch (const std::invalid_argument& error) {
    result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
    return result;
  }
}

MassSummary summarise_mass(const Mechanism& mechanism) {
  const std::vector<dynamics::Parameter> parameters = dynamics::list_parameters(mechanism);
  const VectorX values = dynamics::parameter_values(mechanism),
                added = values.cwiseProduct(added_parameter_mask(mechanism, parameters));
  const VectorX mass = mass_coefficients(parameters), inertia = inertia_coefficients(parameters);
  return {mass.dot(values), inertia.dot(values), mass.dot(added), inertia.dot(added)};
}

std::string rows_text(const MatrixX& matrix) {
  std::string rows;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    rows += i == 0 ? "[" : "; ";
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      const double entry = std::abs(matrix(i, j)) < 1e-12 * matrix.norm() ? 0 : matrix(i, j);
      rows += fmt::format("{}{:.6g}", j == 0 ? "" : ", ", entry);
    }
  }
  return rows + "]";
}

/// "the centre of mass moves by 0.5 times the tool's displacement"
std::string com_tool_map_note(const Mechanism& mechanism, GoalKind kind) {
  const conditions::ComToolMap law = conditions::fit_com_tool_map(mechanism, kind);
  const MatrixX& A = law.A;
  if (A.size() == 0) return "";
  const double factor = A.trace() / static_cast<double>(A.rows());
  const bool is_uniform = (A - factor * MatrixX::Identity(A.rows(), A.cols())).norm() < 1e-9 * (1 + A.norm());
  std::string text = fmt::format("the centre of mass moves by {} times the tool's displacement",
                                 is_uniform ? fmt::format("{:.6g}", factor) : rows_text(A));
  if (law.B.norm() > 1e-9 * characteristic_length(mechanism))
    text += fmt::format(", and by {} m times the change of the axes of the tool's body", rows_text(law.B));
  return text;
}

}  // namespace

void measure_design(const DesignSpace& space, DesignReport& report) {
  report.study_before = space.study_at(report.before);
  report.study_after = space.study_at(report.outcome.x);
  const MassSummary before = summarise_mass(report.study_before.mechanism),
                    after = summarise_mass(report.study_after.mechanism);
  report.mass_before = before.mass;
  report.mass_after = after.mass;
  report.inertia_before = before.inertia;
  report.inertia_after = after.inertia;
  report.added_mass = after.added_mass;
  report.added_inertia = after.added_inertia;
}

void compare_trajectories(DesignReport& report) {
  for (const Trajectory& trajectory : report.study_after.trajectories)
    report.comparisons.push_back({trajectory.name, simulate_named_trajectory(report.study_before, trajectory.name),
                                  simulate_named_trajectory(report.study_after, trajectory.name)});
}

namespace {

/// An interrupted design is still reported if this takes no longer than this time [s].
constexpr double max_report_seconds = 3;

/// Records the progress of the search and the time of its interruption.
class InterruptMonitor {
 public:
  explicit InterruptMonitor(const std::function<bool(const SearchProgress&)>& on_progress)
      : on_progress_(on_progress) {}

  bool operator()(const SearchProgress& progress) {
    last_progress_ = progress;
    if (!interrupt_time_ && !on_progress_(progress)) interrupt_time_ = thread_cpu_time();
    return !interrupt_time_;
  }
  bool is_overdue() { return !(*this)(last_progress_) && thread_cpu_time() - *interrupt_time_ > max_report_seconds; }

 private:
  const std::function<bool(const SearchProgress&)>& on_progress_;
  SearchProgress last_progress_{0, 1};
  std::optional<double> interrupt_time_;
};

/// Whether the figure is the peak of all efforts, the least of which all distributions together reach is convex.
bool is_peak_of_efforts(const ObjectiveTerm& term) {
  return term.size == ObjectiveTerm::Size::none && term.run == ObjectiveTerm::RunMeasure::figure &&
         term.figure == Statistic::peak && term.quantity == "torque" && !term.deviation_multiple;
}

/// No distribution of redundant efforts has a smaller peak than the one of least peak without weights and bounds, of
/// which the least value can be proved: raises the bound to it, unless it is not proved within the time or the problem
/// is another one.
void raise_bound_of_peak_effort(DesignReport& report, const DesignSpace& space, const DesignStudyOptions& options) {
  constexpr double max_bound_time = 10;  // CPU time [s]
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  const bool has_other_figures = terms.size() != 1 || !is_peak_of_efforts(terms.front()) || terms.front().weight <= 0 ||
                                 !space.start.design.subject_to.empty() || space.start.design.cases.size() > 0;
  if (has_other_figures || has_linear_efforts(space.start.mechanism)) return;
  DesignSpace relaxed = space;
  const auto relax = [](auto& mechanism) {
    mechanism.torque_distribution->method = model::DistributionMethod::min_peak;
    for (auto& share : mechanism.torque_distribution->shares) share = {};
  };
  relax(relaxed.start.mechanism);
  if (relaxed.recording) {
    auto recording = std::make_shared<study::Recording>(*relaxed.recording);
    relax(recording->mechanism);
    relaxed.recording = std::move(recording);
  }
  DesignStudyOptions bounded = options;
  bounded.search.max_time = std::min(bounded.search.max_time, max_bound_time);
  bounded.motions = nullptr;
  const DesignOutcome outcome = solve_design(make_design_problem(relaxed, bounded));
  if (outcome.optimality != Optimality::proved_global) return;
  raise_lower_bound(report.outcome, outcome.lower_bound);
  report.notes.push_back("the bound is that of all distributions of the efforts together");
}

DesignReport compute_design_report(const DesignSpace& spec_space, const DesignStudyOptions& options) {
  if (spec_space.start.design.front && options.minimize.empty())
    throw std::invalid_argument(
        "front: a trade-off has many designs, not one; choose a figure to minimize to get one design");
  const study::DesignRequest& request = spec_space.start.design;
  const DesignSpace space = follow_assembly_mode(
      spec_space, keeps_assembly_mode(request, options.minimize.empty() ? request.minimize : options.minimize));
  DesignReport report;
  report.free_numbers = space.start.free_numbers;
  report.before = space.start_values();
  report.cardinality_constraints = list_optional_elements(space);
  if (space.start.design.cases.size() > 0) {
    const LoadCaseStudy study(space, options);
    report.outcome = solve_design(study.problem());
    study.describe(report);
    if (report.outcome.method == DesignMethod::geometric) {
      report.length_bound.emplace();
      report.length_bound->reason = "there are load cases";
    }
  } else {
    const DesignProblem problem = make_design_problem(space, options);
    report.outcome = solve_with_length_bound(space, options, problem, report.length_bound);
  }
  if (report.outcome.status == DesignStatus::unsolved) return report;
  if (report.outcome.optimality != Optimality::proved_global && is_design(report.outcome))
    raise_bound_of_peak_effort(report, space, options);
  if (report.outcome.x.size() > 0 && space.instantiate(report.outcome.x).is_other_mode)
    report.notes.push_back(
        "the design is in another assembly mode than the start values, whose mode does not exist at its lengths; "
        "'assembly_mode: start' under 'design' excludes it");

  measure_design(space, report);
  // With load cases, the figure is the maximum or mean over the cases.
  if (space.start.design.cases.size() == 0 && report.outcome.x.size() > 0)
    report.robust = tolerance::robust_terms(space, report.outcome.x,
                                            options.minimize.empty() ? space.start.design.minimize : options.minimize);
  for (const tolerance::RobustTerm& one : report.robust)
    for (const tolerance::IncompatibleParameter& parameter : one.figure.incompatible_parameters) {
      const std::string note = format_incompatibility_note(parameter);
      if (std::find(report.notes.begin(), report.notes.end(), note) == report.notes.end()) report.notes.push_back(note);
    }
  for (const Goal& goal : report.outcome.conditions.goals)
    if (report.outcome.status == DesignStatus::balanced &&
        (goal.kind == GoalKind::proportional || goal.kind == GoalKind::affine))
      report.notes.push_back(com_tool_map_note(report.study_after.mechanism, goal.kind));
  if (options.compare_trajectories) compare_trajectories(report);
  return report;
}

}  // namespace

DesignReport run_design_study(const DesignSpace& space, const DesignStudyOptions& options) {
  const auto compute = [&space](const DesignStudyOptions& given) {
    DesignReport report = has_free_rows(space.start) ? run_catalogue_study(space, given, compute_design_report)
                                                     : compute_design_report(space, given);
    if (!report.catalogue && !space.start.catalogue_choices.empty())
      report.catalogue.emplace().choices = space.start.catalogue_choices;
    return report;
  };
  if (!options.on_progress) return compute(options);
  InterruptMonitor monitor(options.on_progress);
  DesignStudyOptions watched = options;
  watched.on_progress = [&monitor](const SearchProgress& progress) { return monitor(progress); };
  const Deadline deadline(std::numeric_limits<double>::infinity(), [&monitor] { return monitor.is_overdue(); });
  return compute(watched);
}

}  // namespace balance::design
