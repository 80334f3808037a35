#include "balance/synthesis/design/figure_bound_search.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/certificate/figure_bound.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/figure_request.hpp"
#include "balance/synthesis/design/search_budget.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

using certificate::LengthBound;

namespace {

/// Part of the time of a design for the bound before the search, and its limit [s].
constexpr double figure_first_time_fraction = 0.1, figure_max_first_seconds = 0.5;
/// Part of the remaining time for the search.
constexpr double figure_search_time_fraction = 0.75;
/// Time that the bound may take after a short search [s]; after a longer one, as long as that took.
constexpr double figure_min_second_seconds = 3;
/// Relative: a search from the lengths that the bound found promises at least this improvement.
constexpr double figure_min_improvement = 1e-5;
/// Relative: a design that is better than the bound by more refutes it.
constexpr double figure_refutation_tolerance = 1e-6;

class FigureBoundedSearch {
 public:
  FigureBoundedSearch(const DesignSpace& space, const certificate::FigureProblem& figures,
                      const certificate::ForceRowModel& rows, const DesignProblem& problem)
      : figures_(figures),
        problem_(problem),
        clock_(problem, problem.search.max_time),
        tree_(space, figures, rows, {}) {}

  DesignOutcome solve() {
    raise_bound(std::min(figure_max_first_seconds, figure_first_time_fraction * problem_.search.max_time));
    const double before = clock_.elapsed();
    DesignOutcome outcome = search(problem_, figure_search_time_fraction * clock_.remaining());
    const double searched = clock_.elapsed() - before;
    note(outcome);
    if (clock_.was_interrupted() || outcome.optimality == Optimality::proved_global) return outcome;
    raise_bound(std::min(clock_.remaining(), std::max(figure_min_second_seconds, searched)));
    improve(outcome, searched);
    return outcome;
  }

  /// With the best design found; with a reason if it is refuted.
  LengthBound bound(const DesignOutcome& outcome) const {
    LengthBound result = tree_.result();
    if (!result.reason.empty()) return result;
    result.remarks.emplace_back("figures are those of the motion's samples, in the assembly mode of the start values");
    if (!figures_.ignored.empty())
      result.remarks.push_back(join_with_conjunction(figures_.ignored, "and") +
                               (figures_.ignored.size() > 1 ? " are" : " is") + " left out of the bound");
    if (is_design(outcome) && outcome.objective < result.lower_bound * (1 - figure_refutation_tolerance))
      result.reason = "a design was found that is better than its bound";
    return result;
  }

 private:
  void raise_bound(double seconds) {
    const double end = clock_.elapsed() + seconds;
    tree_.run([&] { return clock_.is_interrupted() || clock_.elapsed() > end; });
  }

  DesignOutcome search(DesignProblem problem, double seconds) {
    const LengthBound known = tree_.result();
    if (known.reason.empty()) problem.proved_lower_bound = known.lower_bound;
    problem.search.max_time = std::max(seconds, 1e-3);
    return solve_design(problem);
  }

  void note(const DesignOutcome& outcome) {
    if (is_design(outcome)) tree_.add_design(outcome.x, outcome.objective);
  }

  /// Searches again, from the lengths that the bound found, if these promise a better design.
  void improve(DesignOutcome& outcome, double seconds) {
    const bool promises = tree_.promising().size() > 0 && is_design(outcome) && figures_.ignored.empty() &&
                          tree_.promised_value() < outcome.objective * (1 - figure_min_improvement);
    if (!promises || clock_.remaining() <= 0 || clock_.is_interrupted()) return;
    DesignProblem again = problem_;
    set_start(again, tree_.promising());
    again.is_single_pass = true;
    DesignOutcome better = search(again, std::min(clock_.remaining(), std::max(figure_min_second_seconds, seconds)));
    if (!is_design(better) || !(better.objective < outcome.objective)) return;
    better.start_objective = outcome.start_objective;
    better.residuals_before = outcome.residuals_before;
    better.effort = outcome.effort;
    better.search_summary = outcome.search_summary;
    better.optimality = outcome.optimality;
    outcome = std::move(better);
    note(outcome);
    if (!clock_.is_interrupted()) raise_bound(std::min(clock_.remaining(), figure_min_second_seconds));
  }

  const certificate::FigureProblem& figures_;
  const DesignProblem& problem_;
  DesignClock clock_;
  certificate::FigureBoundSearch tree_;
};

}  // namespace

bool minimises_motion_figures(const std::vector<ObjectiveTerm>& terms) {
  return !terms.empty() && std::all_of(terms.begin(), terms.end(), [](const ObjectiveTerm& term) {
    return term.size == ObjectiveTerm::Size::none && term.run == ObjectiveTerm::RunMeasure::figure;
  });
}

DesignOutcome solve_with_figure_bound(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                      const DesignProblem& problem, LengthBound& bound) {
  bound = {};
  const certificate::FigureRequest request = read_figure_request(space, terms, bound.reason);
  certificate::FigureProblem figures;
  if (bound.reason.empty()) {
    figures = certificate::read_figure_problem(space, request);
    bound.reason = figures.reason;
  }
  if (!bound.reason.empty()) return solve_design(problem);
  const std::unique_ptr<certificate::ForceRowModel> rows = make_force_row_model(space, terms, figures);
  FigureBoundedSearch search(space, figures, *rows, problem);
  DesignOutcome outcome = search.solve();
  bound = search.bound(outcome);
  bound.unit = simulation::objective_unit(terms, space.start.mechanism);
  if (bound.reason.empty() && is_design(outcome)) raise_lower_bound(outcome, bound.lower_bound);
  return outcome;
}

}  // namespace balance::design
