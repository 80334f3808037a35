#include "balance/synthesis/design/bilevel_search.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/inner_problem.hpp"
#include "balance/synthesis/design/multistart.hpp"
#include "balance/synthesis/design/nlopt_search.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// What is left of conditions that can be met, at round-off of the inner problem.
constexpr double feasibility_tolerance = 1e-7;
/// A descent is done where this little is left.
constexpr double residual_tolerance = 1e-10;
/// Points to start from; local searches.
constexpr int min_samples = 48, samples_per_variable = 24, max_local_searches = 12, max_figure_searches = 5,
              max_search_evaluations = 60;
/// Starts nearer to each other than this, in unit coordinates, are one.
constexpr double min_start_distance = 0.15;
/// Ends whose values differ by less than this part are as good as each other.
constexpr double optimum_tolerance = 1e-5;
/// Part of the time that looking around may take.
constexpr double sampling_time_fraction = 0.3;
/// Times that limits are tightened, by so many times what they are missed by; not those that are missed by more than that part.
constexpr int max_penalty_updates = 3;
constexpr double overshoot_factor = 1.5, max_relative_violation = 0.1;
/// Numbers that the model is not made for: its classification takes their square.
constexpr int max_bilevel_variables = 60;

class BilevelSearch {
 public:
  BilevelSearch(const SolverContext& context, const VectorX& anchor, const ScaledObjective* merit, bool regardless)
      : context_(context),
        anchor_(anchor),
        conditions_(!context.problem.goals.empty() && !regardless),
        figure_(merit != nullptr || context.problem.convex_limits != nullptr),
        objective_(merit) {}

  BilevelResult run() {
    BilevelResult designs;
    if (!is_applicable()) return designs;
    designs.is_applicable = true;
    const std::vector<InnerSolution> points = sample_outer_space();
    if (conditions_) search_balance(points);
    if (figure_) search_figure(points);
    if (context_.problem.convex_limits) tighten_limits();
    collect_designs(designs);
    return designs;
  }

 private:
  using Aim = InnerProblem::Target;

  bool is_applicable() {
    if (context_.problem.is_modular || context_.scaling.size() > max_bilevel_variables) return false;
    if (objective_ != nullptr && !context_.problem.convex_terms_at && !context_.problem.violation_floor) return false;
    const std::optional<std::vector<bool>> matters = find_active_parameters();
    if (!matters) return false;
    model_.emplace(context_, anchor_, *matters);
    if (model_->outer().empty()) return false;
    if (objective_ != nullptr && !context_.problem.violation_floor) size_ = figure_scale();
    return true;
  }

  /// What the figure is with the anchor's masses, or with middling ones: added mass may be none to begin with.
  double figure_scale() const {
    VectorX middling = anchor_;
    for (const int i : inertial_variables(context_)) middling[i] = 0;
    double size = 0;
    for (const VectorX& u : {anchor_, middling})
      if (const double value = std::abs((*objective_)(u, nullptr)); std::isfinite(value)) size = std::max(size, value);
    return size > 0 ? size : 1;
  }

  /// Terms that occur in a condition or in the figure.
  std::optional<std::vector<bool>> find_active_parameters() const {
    const Mechanism mechanism = context_.mechanism(anchor_);
    std::vector<bool> matters(list_terms(mechanism, context_.options.loose_springs).size(), false);
    if (conditions_) {
      MatrixX rows;
      try {
        if (!GoalResidual(mechanism, context_.problem.goals, context_.options).rows(mechanism, rows)) return {};
      } catch (const std::invalid_argument&) {
        return {};
      }
      const double largest = max_abs(rows.colwise().norm());
      for (std::size_t k = 0; k < matters.size(); ++k)
        matters[k] = rows.col(static_cast<Eigen::Index>(k)).norm() > 1e-12 * largest;
    }
    const VectorX x = context_.scaling.to_variables(anchor_);
    if (context_.problem.convex_terms_at) {
      const auto figures = context_.problem.convex_terms_at(x);
      if (!figures) return {};
      mark_active_parameters(*figures, matters);
    }
    if (!context_.problem.convex_limits) return matters;
    const auto limits = context_.problem.convex_limits(x);
    if (!limits) return {};
    for (const ConvexLimit& limit : *limits) mark_active_parameters(limit.figures, matters);
    return matters;
  }

  VectorX outer_variables(const VectorX& u) const { return u(model_->outer()); }
  VectorX insert_outer_variables(const VectorX& part) const {
    VectorX u = anchor_;
    u(model_->outer()) = clip_to_unit_box(part);
    return u;
  }

  Aim aim() const { return !figure_ ? Aim::residual : conditions_ ? Aim::both : Aim::figure; }

  /// The anchor and points that fill the box; where the anchor's configurations do not exist, with their own.
  std::vector<InnerSolution> sample_outer_space() {
    const auto n = static_cast<int>(model_->outer().size());
    std::vector<VectorX> places = {anchor_};
    for (const VectorX& part :
         low_discrepancy_points(std::max(min_samples, samples_per_variable * n), n, context_.problem.search.seed))
      places.push_back(insert_outer_variables(part));
    const double reserve = (1 - sampling_time_fraction) * context_.budget.remaining_time();
    InnerProblem near(context_, *model_, aim(), size_);
    const bool centred = near.set_reference(anchor_);
    std::vector<InnerSolution> points;
    for (const VectorX& u : places) {
      if (context_.budget.remaining_time() < reserve) break;
      InnerSolution solution = centred ? near.solve_at(u) : InnerSolution{};
      if (!solution.is_found && conditions_ && context_.infeasibility_reason(u).empty()) {
        InnerProblem own(context_, *model_, aim(), size_);
        if (own.set_reference(u)) solution = own.solve_at(u);
      }
      if (solution.is_found) points.push_back(std::move(solution));
    }
    return points;
  }

  /// The best by `cost` that are apart from each other.
  template <class Cost>
  std::vector<VectorX> select_starts(const std::vector<InnerSolution>& points, int count, const Cost& cost) const {
    std::vector<std::pair<double, VectorX>> all;
    for (const InnerSolution& point : points) all.emplace_back(cost(point), outer_variables(point.u));
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> chosen;
    for (const auto& [value, v] : all) {
      if (static_cast<int>(chosen.size()) >= count) break;
      if (std::none_of(chosen.begin(), chosen.end(),
                       [&, &v = v](const VectorX& c) { return (c - v).norm() < min_start_distance; }))
        chosen.push_back(v);
    }
    return chosen;
  }

  void record(const InnerSolution& solution) {
    if (solution.is_found) local_optima_.push_back(solution);
  }

  std::vector<InnerSolution>::const_iterator best_optimum() const {
    return std::min_element(local_optima_.begin(), local_optima_.end(),
                            [](const auto& a, const auto& b) { return a.value < b.value; });
  }

  /// Of the local searches those that end as well as the best of them does.
  static int count_repeated_optima(const std::vector<double>& values) {
    if (values.empty()) return 0;
    const double best = *std::min_element(values.begin(), values.end());
    return static_cast<int>(std::count_if(values.begin(), values.end(), [best](double value) {
      return std::abs(value - best) <= optimum_tolerance * std::abs(best);
    }));
  }

  /// Lengths at which the conditions can be met.
  void search_balance(const std::vector<InnerSolution>& points) {
    int found = 0;
    const bool open =
        std::any_of(points.begin(), points.end(), [](const auto& p) { return p.residual < feasibility_tolerance; });
    if (figure_ && open) return;  // the figure's own descents find their way
    for (const VectorX& v : select_starts(points, max_local_searches, [](const auto& p) { return p.residual; })) {
      if (context_.budget.is_spent() || found > (figure_ ? 2 : 0)) break;
      const InnerSolution end = minimise_residual_from(v);
      record(end);
      if (end.is_found && end.residual < feasibility_tolerance) ++found;
    }
  }

  /// Levenberg–Marquardt on what is left with the best masses (variable projection).
  InnerSolution minimise_residual_from(const VectorX& start) {
    ++context_.budget.starts;
    InnerProblem inner(context_, *model_, Aim::residual, 1);
    InnerSolution last;
    if (!inner.set_reference(insert_outer_variables(start))) return last;
    NonlinearSystem equations;
    equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      if (!last.is_found || outer_variables(last.u) != v) {
        InnerSolution next = inner.solve_at(insert_outer_variables(v));
        if (!next.is_found || (values.size() > 0 && next.residual_vector.size() != values.size())) return false;
        last = std::move(next);
      }
      values = last.residual_vector;
      if (last.residual < residual_tolerance || context_.budget.is_spent()) values.setZero();  // the end
      if (jacobian != nullptr) *jacobian = inner.reduced_jacobian(last);
      return jacobian == nullptr || jacobian->allFinite();
    };
    const LeastSquaresResult descent = solve_levenberg_marquardt(equations, start, 40);
    if (!last.is_found || outer_variables(last.u) != descent.u)
      last = inner.solve_at(insert_outer_variables(descent.u));
    return last;
  }

  void search_figure(const std::vector<InnerSolution>& points) {
    std::vector<InnerSolution> all = points;
    for (const InnerSolution& end : local_optima_) all.push_back(end);
    const int count = std::min(max_figure_searches, 1 + static_cast<int>(model_->outer().size()));
    std::vector<double> values;
    for (const VectorX& v : select_starts(all, count, [](const auto& p) { return p.value; })) {
      if (context_.budget.is_spent()) break;
      const InnerSolution end = minimise_figure_from(v);
      if (end.is_found) values.push_back(end.value);
      record(end);
    }
    context_.budget.repeated_optima = count_repeated_optima(values);
    for (const InnerSolution& point : points) record(point);
    const auto best = best_optimum();
    if (best != local_optima_.end() && !context_.budget.is_spent()) record(refine_optimum(outer_variables(best->u)));
  }

  /// Looks at points and keeps the best.
  struct OuterObjective {
    const BilevelSearch& search;
    InnerProblem inner;
    InnerSolution best = {};

    double operator()(const VectorX& v, VectorX* slope) {
      ++search.context_.budget.evaluations;
      InnerSolution here = inner.solve_at(search.insert_outer_variables(v));
      if (!here.is_found) return std::numeric_limits<double>::quiet_NaN();
      if (slope != nullptr) *slope = inner.gradient(here);
      if (slope != nullptr && !slope->allFinite()) slope->setZero(v.size());
      const double value = here.value;
      if (!best.is_found || value < best.value) best = std::move(here);
      return value;
    }
  };

  /// How far the design is beyond the limits as they are told; what the search knows of them are few samples.
  double max_limit_violation(const InnerSolution& end) const {
    VectorX g;
    context_.limits->evaluate(model_->recover_variables(end.u, end.unknowns), g, nullptr);
    return g.size() == 0 ? 0 : g.allFinite() ? -min_coefficient(g) : std::numeric_limits<double>::infinity();
  }

  /// From the best end on, with as much to spare as it is beyond the limits.
  void tighten_limits() {
    if (local_optima_.empty()) return;
    InnerSolution end = *best_optimum();
    for (int round = 0; round < max_penalty_updates && !context_.budget.is_spent(); ++round) {
      const double over = max_limit_violation(end);
      if (!(over > limit_tolerance && over < max_relative_violation)) return;
      limit_margin_ += overshoot_factor * over;
      end = minimise_figure_from(outer_variables(end.u));
      if (end.is_found) end = refine_optimum(outer_variables(end.u));
      if (!end.is_found) return;
      record(end);
    }
  }

  /// Down the figure's slope.
  InnerSolution minimise_figure_from(const VectorX& start) {
    OuterObjective look{*this, InnerProblem(context_, *model_, aim(), size_, limit_margin_)};
    const std::string& asked = context_.problem.search.local;
    if (!look.inner.set_reference(insert_outer_variables(start))) return {};
    ++context_.budget.local_searches;
    NonlinearProgram program;
    program.size = static_cast<int>(start.size());
    program.objective = [&](const VectorX& v, VectorX* slope) { return look(v, slope); };
    const StoppingCriteria limits{max_search_evaluations, context_.budget.remaining_time(), 1e-9, 0.1,
                                  context_.budget.make_stop_callback()};
    search_locally(asked == "auto" ? "slsqp" : asked, program, start, limits);
    return look.best;
  }

  /// Kinks, at which slopes mislead, are left to a search without them.
  InnerSolution refine_optimum(const VectorX& start) {
    OuterObjective look{*this, InnerProblem(context_, *model_, aim(), size_, limit_margin_)};
    if (!look.inner.set_reference(insert_outer_variables(start))) return {};
    MultistartSettings task;
    task.objective = [&](const VectorX& v) { return look(v, nullptr); };
    task.starts = {start};
    task.method = "bobyqa";
    task.max_local_searches = 1;
    task.max_evaluations = 16 + 16 * static_cast<int>(start.size());
    task.initial_step = 0.02;
    task.min_step = 1e-6;
    search_multistart(task, context_.budget);
    return look.best;
  }

  void collect_designs(BilevelResult& designs) {
    const auto cost = [&](const InnerSolution& s) { return figure_ ? s.value : s.residual; };
    std::stable_sort(local_optima_.begin(), local_optima_.end(),
                     [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    if (context_.problem.convex_limits)
      std::stable_partition(local_optima_.begin(), local_optima_.end(),
                            [&](const InnerSolution& end) { return max_limit_violation(end) <= limit_tolerance; });
    for (const InnerSolution& end : local_optima_) {
      const VectorX u = model_->recover_variables(end.u, end.unknowns);
      std::vector<VectorX>& list = end.residual < feasibility_tolerance ? designs.balanced : designs.others;
      const bool known = std::any_of(list.begin(), list.end(), [&](const VectorX& k) { return max_abs(k - u) < 1e-6; });
      if (!known && list.size() < 6) list.push_back(u);
    }
  }

  const SolverContext& context_;
  const VectorX& anchor_;
  bool conditions_, figure_;
  const ScaledObjective* objective_;
  std::optional<ConvexMassModel> model_;
  double size_ = 1, limit_margin_ = 0;
  std::vector<InnerSolution> local_optima_;
};

}  // namespace

BilevelResult search_bilevel(const SolverContext& context, const VectorX& anchor, const ScaledObjective* merit,
                             bool regardless) {
  return BilevelSearch(context, anchor, merit, regardless).run();
}

}  // namespace balance::design
