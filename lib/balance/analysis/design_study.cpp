#include "balance/analysis/design_study.hpp"

#include "balance/analysis/duties.hpp"
#include "balance/analysis/figure_limits.hpp"
#include "balance/analysis/finite_trial.hpp"
#include "balance/analysis/load_case_study.hpp"
#include "balance/analysis/objective.hpp"
#include "balance/analysis/objective_pieces.hpp"
#include "balance/analysis/offered.hpp"
#include "balance/analysis/start_pose.hpp"
#include "balance/base/computing_time.hpp"
#include "balance/conditions/modular.hpp"
#include "balance/conditions/proportion.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/study/passing_payloads.hpp"

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
struct Weight {
  double mass = 0, inertia = 0, added_mass = 0, added_inertia = 0;
};

DesignProblem state(const DesignSpace& space, const DesignStudyOptions& options) {
  DesignProblem problem;
  for (const FreeNumber& number : space.start.free_numbers)
    problem.variables.push_back({number.path, number.lower, number.upper, number.start, number.sizes});
  const auto duties = std::make_shared<const Duties>(space.start);
  problem.mechanism_at = [&space, duties](const VectorX& x) {
    return assembled_at(finite_trial(space, x).mechanism, duties->coordinates());
  };
  problem.fault = [&space](const VectorX& x) { return first_fault(finite_trial(space, x).mechanism); };
  problem.obstacle = [&space, duties](const VectorX& x) { return duties->obstacle(finite_trial(space, x)); };
  problem.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  if (!problem.goals.empty()) refuse_passing_payloads(space.start, "the goals of a design", &options.without);
  if (!space.start.design.cases.adapted.empty()) refuse_passing_payloads(space.start, "numbers that follow the load");
  if (problem.variables.empty()) throw std::invalid_argument("a design needs free numbers, and the spec has none");
  problem.choices = list_choices(space);
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  const std::vector<FigureLimit>& limits = space.start.design.subject_to;
  if (problem.goals.empty() && terms.empty() && limits.empty())
    throw std::invalid_argument("a design needs a goal, something to minimize or limits");
  if (!space.start.trajectories.empty()) problem.options.about = space.start.trajectories.front().about;
  problem.derive = options.modular ? derive_modular_conditions : derive_conditions;
  problem.modular = options.modular;
  problem.search = options.search;
  problem.watch = options.watch;
  problem.options.without = options.without;
  problem.options.loose_springs = find_loose_springs(problem);
  problem.limits = build_limits(space, limits, space.start_values(), problem.options.loose_springs);
  problem.limits_at = [&space, &limits](const VectorX& x, const std::vector<int>& kept, const LooseSprings& loose) {
    return build_limits(space.held(x, kept), limits, x(kept), loose);
  };
  problem.bounded_at = build_bounded(space, limits, problem.options.loose_springs, problem.bounded);
  if (terms.empty()) return problem;
  problem.objective = build_objective(space, terms, space.start_values(), problem.options.loose_springs);
  // where numbers are off, slopes are differences: they would be second derivatives
  const auto robust = [](const ObjectiveTerm& term) { return term.plus.has_value(); };
  if (std::none_of(terms.begin(), terms.end(), robust))
    problem.pieces_at = [&space, terms, loose = problem.options.loose_springs](const VectorX& x) {
      return objective_pieces(space, terms, loose, x);
    };
  problem.figures_at = build_figures(space, terms, problem.options.loose_springs);
  problem.whole_figures_at = build_figures(space, terms, problem.options.loose_springs, FigureSamples::all);
  problem.objective_at = [&space, terms](const VectorX& x, const std::vector<int>& kept, const LooseSprings& loose) {
    return build_objective(space.held(x, kept), terms, x(kept), loose);
  };
  return problem;
}

}  // namespace

DesignProblem state_problem(const DesignSpace& space, const DesignStudyOptions& options) {
  constexpr double min_seconds = 5;  // for the first look at each motion, however short the search is to be
  const double seconds = std::max(min_seconds, options.search.seconds);
  try {
    const Deadline deadline(seconds, [&] { return options.watch && !options.watch({0, seconds}); });
    return state(space, options);
  } catch (const OutOfTime&) {
    throw OutOfTime(
        fmt::format("the motions of the spec could not be tried with its start values within {:g} s: give the "
                    "search more (--seconds, or seconds: of search:), or leave out trajectories that do not matter",
                    seconds));
  }
}

namespace {

Result run(const Study& study, const std::string& name) {
  for (const Trajectory& trajectory : study.trajectories) {
    if (trajectory.name != name) continue;
    try {
      return simulate(study.mechanism, trajectory);
    } catch (const std::invalid_argument& error) {
      Result result;
      result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
      return result;
    }
  }
  return {};
}

Weight weigh(const Mechanism& mechanism) {
  const std::vector<Parameter> parameters = list_parameters(mechanism);
  const VectorX values = parameter_values(mechanism), added = values.cwiseProduct(is_added(mechanism, parameters));
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
std::string law_note(const Mechanism& mechanism, GoalKind kind) {
  const ComLaw law = com_law(mechanism, kind);
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
  report.study_before = space.at(report.before);
  report.study_after = space.at(report.outcome.x);
  const Weight before = weigh(report.study_before.mechanism), after = weigh(report.study_after.mechanism);
  report.mass_before = before.mass;
  report.mass_after = after.mass;
  report.inertia_before = before.inertia;
  report.inertia_after = after.inertia;
  report.added_mass = after.added_mass;
  report.added_inertia = after.added_inertia;
}

void compare_trajectories(DesignReport& report) {
  for (const Trajectory& trajectory : report.study_after.trajectories)
    report.comparisons.push_back(
        {trajectory.name, run(report.study_before, trajectory.name), run(report.study_after, trajectory.name)});
}

namespace {

/// Who interrupts a design gets the best so far, if what is told of it takes no longer than this [s].
constexpr double max_seconds_to_tell = 3;

/// Keeps how far the search is, and since when nobody wants it any more.
class Watch {
 public:
  explicit Watch(const std::function<bool(const SearchProgress&)>& watch) : watch_(watch) {}

  bool operator()(const SearchProgress& progress) {
    last_ = progress;
    if (!interrupted_ && !watch_(progress)) interrupted_ = computing_time();
    return !interrupted_;
  }
  bool is_overdue() { return !(*this)(last_) && computing_time() - *interrupted_ > max_seconds_to_tell; }

 private:
  const std::function<bool(const SearchProgress&)>& watch_;
  SearchProgress last_{0, 1};
  std::optional<double> interrupted_;
};

DesignReport study_design(const DesignSpace& space, const DesignStudyOptions& options) {
  if (space.start.design.front && options.minimize.empty())
    throw std::invalid_argument(
        "front: a trade-off has many designs, not one; say which figure to minimize to get one design");
  DesignReport report;
  report.numbers = space.start.free_numbers;
  report.before = space.start_values();
  report.choices = list_choices(space);
  if (space.start.design.cases.size() > 0) {
    const LoadCaseStudy study(space, options);
    report.outcome = solve(study.problem());
    study.describe(report);
  } else {
    report.outcome = solve(state_problem(space, options));
  }
  if (report.outcome.status == DesignStatus::unsolved) return report;

  measure_design(space, report);
  // with load cases it is the worst case's figure that counts, or the mean of all
  if (space.start.design.cases.size() == 0 && report.outcome.x.size() > 0)
    report.robust = robust_terms(space, report.outcome.x,
                                 options.minimize.empty() ? space.start.design.minimize : options.minimize);
  for (const RobustTerm& one : report.robust)
    for (const NumberOpening& opening : one.figure.openings) {
      const std::string note = opening_note(opening);
      if (std::find(report.notes.begin(), report.notes.end(), note) == report.notes.end()) report.notes.push_back(note);
    }
  for (const Goal& goal : report.outcome.conditions.goals)
    if (report.outcome.status == DesignStatus::balanced &&
        (goal.kind == GoalKind::proportional || goal.kind == GoalKind::affine))
      report.notes.push_back(law_note(report.study_after.mechanism, goal.kind));
  if (options.trajectories) compare_trajectories(report);
  return report;
}

}  // namespace

DesignReport design_study(const DesignSpace& space, const DesignStudyOptions& options) {
  if (!options.watch) return study_design(space, options);
  Watch watch(options.watch);
  DesignStudyOptions watched = options;
  watched.watch = [&watch](const SearchProgress& progress) { return watch(progress); };
  const Deadline patience(std::numeric_limits<double>::infinity(), [&watch] { return watch.is_overdue(); });
  return study_design(space, watched);
}

}  // namespace balance
