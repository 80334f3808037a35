#include "balance/synthesis/design/design_study.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/com_tool_map.hpp"
#include "balance/synthesis/conditions/modular_conditions.hpp"
#include "balance/synthesis/design/load_case_study.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/optional_elements.hpp"
#include "balance/synthesis/design/required_motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

/// What a mechanism weighs, and what of it was added to balance it.
struct MassSummary {
  double mass = 0, inertia = 0, added_mass = 0, added_inertia = 0;
};

DesignProblem build_design_problem(const DesignSpace& space, const DesignStudyOptions& options) {
  DesignProblem problem;
  for (const FreeNumber& number : space.start.free_numbers)
    problem.variables.push_back({number.key_path, number.lower, number.upper, number.start, number.discrete_values});
  const auto duties = std::make_shared<const RequiredMotions>(space.start);
  problem.build_mechanism = [&space, duties](const VectorX& x) {
    return assembled_at(instantiate_checked(space, x).mechanism, duties->start_coordinates());
  };
  problem.invalidity_reason = [&space](const VectorX& x) {
    return find_validation_issue(instantiate_checked(space, x).mechanism);
  };
  problem.infeasibility_reason = [&space, duties](const VectorX& x) {
    return duties->infeasibility_reason(instantiate_checked(space, x));
  };
  problem.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  if (!problem.goals.empty()) reject_temporary_payloads(space.start, "the goals of a design", &options.excluded);
  if (!space.start.design.cases.adapted.empty()) reject_temporary_payloads(space.start, "numbers that follow the load");
  if (problem.variables.empty()) throw std::invalid_argument("a design needs free numbers, and the spec has none");
  problem.cardinality_constraints = list_optional_elements(space);
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  const std::vector<FigureLimit>& limits = space.start.design.subject_to;
  if (problem.goals.empty() && terms.empty() && limits.empty())
    throw std::invalid_argument("a design needs a goal, something to minimize or limits");
  if (!space.start.trajectories.empty()) problem.options.about = space.start.trajectories.front().about;
  problem.derive_conditions = options.is_modular ? derive_modular_conditions : derive_conditions;
  problem.is_modular = options.is_modular;
  problem.search = options.search;
  problem.on_progress = options.on_progress;
  problem.options.excluded = options.excluded;
  problem.options.loose_springs = find_loose_springs(problem);
  problem.limits = build_design_limits(space, limits, space.start_values(), problem.options.loose_springs);
  problem.limits_at_geometry = [&space, &limits](const VectorX& x, const std::vector<int>& kept,
                                                 const FreeSprings& loose) {
    return build_design_limits(space.fix_others(x, kept), limits, x(kept), loose);
  };
  problem.convex_limits = build_convex_limits(space, limits, problem.options.loose_springs, problem.convex_limit_count);
  if (terms.empty()) return problem;
  problem.objective = build_objective(space, terms, space.start_values(), problem.options.loose_springs);
  // where numbers are off, slopes are differences: they would be second derivatives
  const auto robust = [](const ObjectiveTerm& term) { return term.deviation_multiple.has_value(); };
  if (std::none_of(terms.begin(), terms.end(), robust))
    problem.max_terms = [&space, terms, loose = problem.options.loose_springs](const VectorX& x) {
      return compute_max_terms(space, terms, loose, x);
    };
  problem.convex_terms_at = build_convex_terms(space, terms, problem.options.loose_springs);
  problem.all_convex_terms_at = build_convex_terms(space, terms, problem.options.loose_springs, FigureSampling::full);
  problem.objective_at_geometry = [&space, terms](const VectorX& x, const std::vector<int>& kept,
                                                  const FreeSprings& loose) {
    return build_objective(space.fix_others(x, kept), terms, x(kept), loose);
  };
  return problem;
}

}  // namespace

DesignProblem make_design_problem(const DesignSpace& space, const DesignStudyOptions& options) {
  constexpr double min_seconds = 5;  // for the first look at each motion, however short the search is to be
  const double seconds = std::max(min_seconds, options.search.max_time);
  try {
    const Deadline deadline(seconds, [&] { return options.on_progress && !options.on_progress({0, seconds}); });
    return build_design_problem(space, options);
  } catch (const DeadlineExceeded&) {
    throw DeadlineExceeded(
        fmt::format("the motions of the spec could not be tried with its start values within {:g} s: give the "
                    "search more (--seconds, or seconds: of search:), or leave out trajectories that do not matter",
                    seconds));
  }
}

namespace {

RunResult simulate_named_trajectory(const Study& study, const std::string& name) {
  for (const Trajectory& trajectory : study.trajectories) {
    if (trajectory.name != name) continue;
    try {
      return simulate(study.mechanism, trajectory);
    } catch (const std::invalid_argument& error) {
      RunResult result;
      result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
      return result;
    }
  }
  return {};
}

MassSummary summarise_mass(const Mechanism& mechanism) {
  const std::vector<Parameter> parameters = list_parameters(mechanism);
  const VectorX values = parameter_values(mechanism),
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
  const ComToolMap law = fit_com_tool_map(mechanism, kind);
  const MatrixX& A = law.A;
  if (A.size() == 0) return "";
  const double factor = A.trace() / static_cast<double>(A.rows());
  const bool alike = (A - factor * MatrixX::Identity(A.rows(), A.cols())).norm() < 1e-9 * (1 + A.norm());
  std::string text = fmt::format("the centre of mass moves by {} times the tool's displacement",
                                 alike ? fmt::format("{:.6g}", factor) : rows_text(A));
  if (law.B.norm() > 1e-9 * characteristic_length(mechanism))
    text += fmt::format(", and by {} m times what the axes of the tool's body change by", rows_text(law.B));
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

/// Who interrupts a design gets the best so far, if what is told of it takes no longer than this [s].
constexpr double max_report_seconds = 3;

/// Keeps how far the search is, and since when nobody wants it any more.
class InterruptMonitor {
 public:
  explicit InterruptMonitor(const std::function<bool(const SearchProgress&)>& watch) : on_progress_(watch) {}

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

DesignReport compute_design_report(const DesignSpace& space, const DesignStudyOptions& options) {
  if (space.start.design.front && options.minimize.empty())
    throw std::invalid_argument(
        "front: a trade-off has many designs, not one; say which figure to minimize to get one design");
  DesignReport report;
  report.free_numbers = space.start.free_numbers;
  report.before = space.start_values();
  report.cardinality_constraints = list_optional_elements(space);
  if (space.start.design.cases.size() > 0) {
    const LoadCaseStudy study(space, options);
    report.outcome = solve_design(study.problem());
    study.describe(report);
  } else {
    report.outcome = solve_design(make_design_problem(space, options));
  }
  if (report.outcome.status == DesignStatus::unsolved) return report;

  measure_design(space, report);
  // with load cases it is the worst case's figure that counts, or the mean of all
  if (space.start.design.cases.size() == 0 && report.outcome.x.size() > 0)
    report.robust = robust_terms(space, report.outcome.x,
                                 options.minimize.empty() ? space.start.design.minimize : options.minimize);
  for (const RobustTerm& one : report.robust)
    for (const IncompatibleParameter& opening : one.figure.incompatible_parameters) {
      const std::string note = format_incompatibility_note(opening);
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
  if (!options.on_progress) return compute_design_report(space, options);
  InterruptMonitor watch(options.on_progress);
  DesignStudyOptions watched = options;
  watched.on_progress = [&watch](const SearchProgress& progress) { return watch(progress); };
  const Deadline patience(std::numeric_limits<double>::infinity(), [&watch] { return watch.is_overdue(); });
  return compute_design_report(space, watched);
}

}  // namespace balance
