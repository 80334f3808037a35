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

/// Residual below which conditions count as met; round-off of the inner problem.
constexpr double feasibility_tolerance = 1e-7;
/// Residual at which a descent stops.
constexpr double residual_tolerance = 1e-10;
/// Numbers of samples, and limits of the local searches.
constexpr int min_samples = 48, samples_per_variable = 24, max_local_searches = 12, max_figure_searches = 5,
              max_search_evaluations = 60;
/// Starts closer together than this in unit coordinates count as one.
constexpr double min_start_distance = 0.15;
/// Number of tangents of the boundary of assembly; the farthest point that shows it; the accuracy to which it is found;
/// the distance of the points that give its tangent, and how steep that is at most.
constexpr int max_boundary_cuts = 8;
constexpr double max_boundary_distance = 0.5, boundary_tolerance = 1e-8, boundary_step = 1e-3, max_boundary_slope = 20;
/// Relative decrease by a search without gradients that shows kinks, where gradients mislead.
constexpr double kink_threshold = 1e-7;
/// Number of times that searches with and without gradients alternate at kinks.
constexpr int max_refinements = 4;
/// Maximum number of times that the limits are tightened, by overshoot_factor times their violation; larger violations
/// than max_relative_violation are left alone.
constexpr int max_penalty_updates = 3;
constexpr double overshoot_factor = 1.5, max_relative_violation = 0.1;
/// Maximum number of variables: the classification of the model takes quadratic time.
constexpr int max_bilevel_variables = 60;

class BilevelSearch {
 public:
  BilevelSearch(const SolverContext& context, const VectorX& anchor, const ScaledObjective* objective,
                bool ignore_conditions, const StartEndHandler& handle_start_end)
      : context_(context),
        capabilities_(context.problem.model->capabilities()),
        anchor_(anchor),
        has_conditions_(!context.problem.goals.empty() && !ignore_conditions),
        has_figure_(objective != nullptr || capabilities_.has_convex_limits),
        objective_(objective),
        handle_start_end_(handle_start_end) {}

  BilevelResult run() {
    BilevelResult designs;
    if (!is_applicable()) return designs;
    designs.is_applicable = true;
    // The anchor comes first, so that there is a design soon.
    if (has_figure_) search_figure_from(outer_variables(anchor_));
    if (!is_finished_ || has_conditions_) {
      const std::vector<InnerSolution> points = sample_outer_space();
      if (has_conditions_) search_balance(points);
      if (has_figure_) search_figure(points);
    }
    if (capabilities_.has_convex_limits) tighten_limits();
    collect_designs(designs);
    return designs;
  }

 private:
  using Target = InnerProblem::Target;

  bool is_applicable() {
    if (context_.problem.derives_anew || context_.scaling.size() > max_bilevel_variables) return false;
    if (objective_ != nullptr && !capabilities_.has_convex_terms && !context_.problem.violation_floor) return false;
    const std::optional<std::vector<bool>> is_active_parameter = find_active_parameters();
    if (!is_active_parameter) return false;
    model_.emplace(context_, anchor_, *is_active_parameter);
    if (model_->outer().empty()) return false;
    if (objective_ != nullptr && !context_.problem.violation_floor) figure_scale_ = figure_scale();
    find_geometric_limits();
    return true;
  }

  /// Limits that depend on the outer variables only, such as those of distances.
  void find_geometric_limits() {
    VectorX u = -anchor_;
    u(model_->outer()) = anchor_(model_->outer());
    for (int k = 0; k < context_.limits->size(); ++k)
      if (context_.limits->value(u, k) == context_.limits->value(anchor_, k)) geometric_limits_.push_back(k);
  }

  /// The inner problem where the geometric limits, which it does not know, are satisfied.
  InnerSolution solve_within_limits(const InnerProblem& inner, const VectorX& u) const {
    const bool is_within = std::all_of(geometric_limits_.begin(), geometric_limits_.end(),
                                       [&](int k) { return context_.limits->is_satisfied(u, k); });
    return is_within ? inner.solve_at(u) : InnerSolution{};
  }

  /// Value of the figure with the masses of the anchor or in the middle of their bounds, because the added mass may be
  /// zero at the anchor.
  double figure_scale() const {
    VectorX middling = anchor_;
    for (const int i : inertial_variables(context_)) middling[i] = 0;
    double scale = 0;
    for (const VectorX& u : {anchor_, middling})
      if (const double value = std::abs((*objective_)(u, nullptr)); std::isfinite(value))
        scale = std::max(scale, value);
    return scale > 0 ? scale : 1;
  }

  /// Marks the terms that occur in a condition or in the figure.
  std::optional<std::vector<bool>> find_active_parameters() const {
    const Mechanism mechanism = context_.mechanism(anchor_);
    std::vector<bool> is_active_parameter(conditions::list_terms(mechanism, context_.options.loose_springs).size(),
                                          false);
    if (has_conditions_) {
      MatrixX rows;
      try {
        if (!conditions::GoalResidual(mechanism, context_.problem.goals, context_.options).rows(mechanism, rows))
          return {};
      } catch (const std::invalid_argument&) {
        return {};
      }
      const double largest = numerics::max_abs(rows.colwise().norm());
      for (std::size_t k = 0; k < is_active_parameter.size(); ++k)
        is_active_parameter[k] = rows.col(static_cast<Eigen::Index>(k)).norm() > 1e-12 * largest;
    }
    if (capabilities_.has_convex_terms) {
      const auto figures = context_.convex_terms(anchor_, FigureSampling::coarse);
      if (!figures) return {};
      mark_active_parameters(*figures, is_active_parameter);
    }
    if (!capabilities_.has_convex_limits) return is_active_parameter;
    const auto limits = context_.convex_limits(anchor_);
    if (!limits) return {};
    for (const ConvexLimit& limit : *limits) mark_active_parameters(limit.figures, is_active_parameter);
    return is_active_parameter;
  }

  VectorX outer_variables(const VectorX& u) const { return u(model_->outer()); }
  VectorX insert_outer_variables(const VectorX& outer_values) const {
    VectorX u = anchor_;
    u(model_->outer()) = clip_to_unit_box(outer_values);
    return u;
  }

  Target target() const { return !has_figure_ ? Target::residual : has_conditions_ ? Target::both : Target::figure; }

  /// Solves the inner problem at the anchor and at space-filling points. Points where the anchor's configurations do
  /// not exist use their own.
  std::vector<InnerSolution> sample_outer_space() {
    const auto n = static_cast<int>(model_->outer().size());
    std::vector<VectorX> sample_points = {anchor_};
    for (const VectorX& outer_values :
         low_discrepancy_points(std::max(min_samples, samples_per_variable * n), n, context_.problem.search.seed))
      sample_points.push_back(insert_outer_variables(outer_values));
    InnerProblem anchor_problem(context_, *model_, target(), figure_scale_);
    const bool has_anchor_reference = anchor_problem.set_reference(anchor_);
    std::vector<InnerSolution> points;
    for (const VectorX& u : sample_points) {
      if (context_.budget.is_spent()) break;
      InnerSolution solution = has_anchor_reference ? solve_within_limits(anchor_problem, u) : InnerSolution{};
      if (!solution.is_found && has_conditions_ && context_.infeasibility_reason(u).empty()) {
        InnerProblem point_problem(context_, *model_, target(), figure_scale_);
        if (point_problem.set_reference(u)) solution = solve_within_limits(point_problem, u);
      }
      if (solution.is_found) points.push_back(std::move(solution));
    }
    return points;
  }

  /// The best points by `cost` that are sufficiently far from each other.
  template <class Cost>
  std::vector<VectorX> select_starts(const std::vector<InnerSolution>& points, int count, const Cost& cost) const {
    std::vector<std::pair<double, VectorX>> ranked;
    for (const InnerSolution& point : points) ranked.emplace_back(cost(point), outer_variables(point.u));
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> chosen;
    for (const auto& [value, v] : ranked) {
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

  /// Finds lengths at which the conditions can be met.
  void search_balance(const std::vector<InnerSolution>& points) {
    int balanced_count = 0;
    const bool has_balanced_point =
        std::any_of(points.begin(), points.end(), [](const auto& p) { return p.residual < feasibility_tolerance; });
    if (has_figure_ && has_balanced_point) return;  // the descents of the figure suffice
    for (const VectorX& v : select_starts(points, max_local_searches, [](const auto& p) { return p.residual; })) {
      if (context_.budget.is_spent() || balanced_count > (has_figure_ ? 2 : 0)) break;
      const InnerSolution optimum = minimise_residual_from(v);
      record(optimum);
      if (optimum.is_found && optimum.residual < feasibility_tolerance) ++balanced_count;
    }
  }

  /// Levenberg–Marquardt on the residual with the best masses (variable projection).
  InnerSolution minimise_residual_from(const VectorX& start) {
    ++context_.budget.starts;
    InnerProblem inner(context_, *model_, Target::residual, 1);
    InnerSolution last;
    if (!inner.set_reference(insert_outer_variables(start))) return last;
    numerics::NonlinearSystem equations;
    equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      if (!last.is_found || outer_variables(last.u) != v) {
        InnerSolution next = solve_within_limits(inner, insert_outer_variables(v));
        if (!next.is_found || (values.size() > 0 && next.residual_vector.size() != values.size())) return false;
        last = std::move(next);
      }
      values = last.residual_vector;
      if (last.residual < residual_tolerance || context_.budget.is_spent()) values.setZero();  // stops
      if (jacobian != nullptr) *jacobian = inner.reduced_jacobian(last);
      return jacobian == nullptr || jacobian->allFinite();
    };
    const numerics::LeastSquaresResult descent = solve_levenberg_marquardt(equations, start, 40);
    if (!last.is_found || outer_variables(last.u) != descent.u)
      last = solve_within_limits(inner, insert_outer_variables(descent.u));
    return last;
  }

  void search_figure(const std::vector<InnerSolution>& points) {
    std::vector<InnerSolution> candidates = points;
    for (const InnerSolution& optimum : local_optima_) candidates.push_back(optimum);
    const int count = std::min(max_figure_searches, 1 + static_cast<int>(model_->outer().size()));
    for (const VectorX& v : select_starts(candidates, count, [](const auto& p) { return p.value; }))
      search_figure_from(v);
    for (const InnerSolution& point : points) record(point);
  }

  /// One start; none if enough of them agree or the time is over.
  void search_figure_from(const VectorX& start) {
    if (is_finished_ || context_.budget.is_spent() || std::any_of(begun_.begin(), begun_.end(), [&](const VectorX& v) {
          return (v - start).norm() < min_start_distance;
        }))
      return;
    begun_.push_back(start);
    InnerSolution optimum = minimise_figure_from(start);
    // Others are improved on all variables at once, where kinks of the inner optimum are bounds of the masses.
    if (optimum.is_found && (objective_ == nullptr || objective_->is_simulated() || capabilities_.has_convex_limits))
      optimum = descend_along_kinks(std::move(optimum));
    record(optimum);
    if (!handle_start_end_) return;
    const VectorX u = optimum.is_found ? model_->recover_variables(optimum.u, optimum.unknowns) : VectorX();
    is_finished_ = handle_start_end_(u, optimum.is_found && optimum.residual < feasibility_tolerance);
  }

  /// Continues a descent without gradients, and from its end with gradients, as long as that helps. Where it does not
  /// help the first start, the value is smooth.
  InnerSolution descend_along_kinks(InnerSolution optimum) {
    for (int round = 0; round < max_refinements && has_kinks_ && !context_.budget.is_spent(); ++round) {
      const double before = optimum.value;
      for (const bool with_gradients : {false, true}) {
        InnerSolution next = with_gradients ? minimise_figure_from(outer_variables(optimum.u))
                                            : refine_optimum(outer_variables(optimum.u));
        if (next.is_found && next.value < optimum.value) optimum = std::move(next);
        const bool has_improved = optimum.value < before - kink_threshold * std::abs(before);
        if (!with_gradients && !has_improved) {
          if (round == 0 && begun_.size() == 1) has_kinks_ = false;
          return optimum;
        }
      }
    }
    return optimum;
  }

  /// Evaluates points and records the best.
  struct OuterObjective {
    const BilevelSearch& search;
    InnerProblem inner;
    InnerSolution best = {};
    std::vector<VectorX> undefined = {};  ///< points without a solution

    double operator()(const VectorX& v, VectorX* gradient) {
      ++search.context_.budget.evaluations;
      InnerSolution solution = search.solve_within_limits(inner, search.insert_outer_variables(v));
      if (!solution.is_found) {
        undefined.push_back(v);
        return std::numeric_limits<double>::quiet_NaN();
      }
      if (gradient != nullptr) *gradient = inner.gradient(solution);
      if (gradient != nullptr && !gradient->allFinite()) gradient->setZero(v.size());
      const double value = solution.value;
      if (!best.is_found || value < best.value) best = std::move(solution);
      return value;
    }
  };

  /// Violation of the actual limits; the search evaluates them at few samples.
  double max_limit_violation(const InnerSolution& optimum) const {
    VectorX g;
    context_.limits->evaluate(model_->recover_variables(optimum.u, optimum.unknowns), g, nullptr);
    return g.size() == 0 ? 0 : g.allFinite() ? -numerics::min_coefficient(g) : std::numeric_limits<double>::infinity();
  }

  /// Repeats the search from the best optimum, with the limits tightened in proportion to their violation.
  void tighten_limits() {
    if (local_optima_.empty()) return;
    InnerSolution optimum = *best_optimum();
    for (int round = 0; round < max_penalty_updates && !context_.budget.is_spent(); ++round) {
      const double violation = max_limit_violation(optimum);
      if (!(violation > limit_tolerance && violation < max_relative_violation)) return;
      limit_margin_ += overshoot_factor * violation;
      optimum = minimise_figure_from(outer_variables(optimum.u));
      if (optimum.is_found) optimum = refine_optimum(outer_variables(optimum.u));
      if (!optimum.is_found) return;
      record(optimum);
    }
  }

  /// An estimated tangent of the boundary beyond which the mechanism cannot be assembled or follow its motions:
  /// normal · v ≤ offset.
  struct BoundaryCut {
    VectorX normal;
    double offset;
  };

  /// Gradient descent of the figure. Where points without a solution stop it, it continues along the boundary.
  InnerSolution minimise_figure_from(const VectorX& start) {
    OuterObjective outer_objective{*this, InnerProblem(context_, *model_, target(), figure_scale_, limit_margin_)};
    if (!outer_objective.inner.set_reference(insert_outer_variables(start))) return {};
    ++context_.budget.local_searches;
    std::vector<BoundaryCut> cuts;
    descend(outer_objective, start, cuts);
    const InnerSolution& best = outer_objective.best;
    for (int k = 0; k < max_boundary_cuts && best.is_found && !context_.budget.is_spent(); ++k) {
      const double before = best.value;
      const std::optional<BoundaryCut> cut = find_boundary_cut(outer_objective);
      if (!cut) break;
      cuts.push_back(*cut);
      outer_objective.undefined.clear();
      descend(outer_objective, outer_variables(best.u), cuts);
      if (!(best.value < before - kink_threshold * std::abs(before))) break;
    }
    return best;
  }

  void descend(OuterObjective& outer_objective, const VectorX& start, const std::vector<BoundaryCut>& cuts) const {
    const std::string& requested_method = context_.problem.search.local;
    NonlinearProgram program;
    program.size = static_cast<int>(start.size());
    program.objective = [&](const VectorX& v, VectorX* gradient) { return outer_objective(v, gradient); };
    program.inequality_count = static_cast<int>(cuts.size());
    program.inequalities = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      for (std::size_t k = 0; k < cuts.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        values[row] = cuts[k].offset - cuts[k].normal.dot(v);
        if (jacobian != nullptr) jacobian->row(row) = -cuts[k].normal.transpose();
      }
    };
    const StoppingCriteria limits{max_search_evaluations, context_.budget.remaining_time(), 1e-9, 0.1,
                                  context_.budget.make_stop_callback()};
    search_locally(requested_method == "auto" ? "slsqp" : requested_method, program, start, limits);
  }

  /// Bisects towards the nearest point without a solution, and along parallel lines next to it.
  std::optional<BoundaryCut> find_boundary_cut(const OuterObjective& outer_objective) const {
    const VectorX inside = outer_variables(outer_objective.best.u);
    const VectorX* blocked = nullptr;
    for (const VectorX& v : outer_objective.undefined)
      if (blocked == nullptr || (v - inside).norm() < (*blocked - inside).norm()) blocked = &v;
    if (blocked == nullptr || !((*blocked - inside).norm() < max_boundary_distance)) return std::nullopt;
    const auto is_defined = [&](const VectorX& v) {
      return solve_within_limits(outer_objective.inner, insert_outer_variables(v)).is_found;
    };
    /// The last point from a defined to an undefined one.
    const auto bisect = [&](double defined, double undefined, const auto& point) {
      while (std::abs(undefined - defined) > boundary_tolerance && !context_.budget.is_spent()) {
        const double middle = (defined + undefined) / 2;
        (is_defined(point(middle)) ? defined : undefined) = middle;
      }
      return defined;
    };
    const double distance = (*blocked - inside).norm();
    const VectorX direction = (*blocked - inside) / distance;
    const auto along = [&](double t) { return VectorX(inside + t * direction); };
    const VectorX boundary = along(bisect(0, distance, along));
    // the normal is direction − Σ slope · tangent, with the boundary's slopes over the tangents
    const Eigen::HouseholderQR<MatrixX> qr(direction);
    const MatrixX basis = qr.householderQ() * MatrixX::Identity(direction.size(), direction.size());
    VectorX normal = direction;
    for (Eigen::Index k = 1; k < basis.cols(); ++k) {
      VectorX tangent = basis.col(k);
      if (numerics::max_abs(boundary + boundary_step * tangent) > 1) tangent = -tangent;
      const auto beside = [&](double t) { return VectorX(boundary + boundary_step * tangent + t * direction); };
      double defined = 0, undefined = 0;
      if (is_defined(beside(0)))
        undefined = max_boundary_slope * boundary_step;
      else
        defined = -max_boundary_slope * boundary_step;
      if (is_defined(beside(undefined)) || !is_defined(beside(defined))) continue;
      normal -= bisect(defined, undefined, beside) / boundary_step * tangent;
    }
    return BoundaryCut{normal, normal.dot(boundary)};
  }

  /// Derivative-free search, because gradients are misleading at kinks.
  InnerSolution refine_optimum(const VectorX& start) {
    OuterObjective outer_objective{*this, InnerProblem(context_, *model_, target(), figure_scale_, limit_margin_)};
    if (!outer_objective.inner.set_reference(insert_outer_variables(start))) return {};
    MultistartSettings settings;
    settings.objective = [&](const VectorX& v) { return outer_objective(v, nullptr); };
    settings.starts = {start};
    settings.method = "bobyqa";
    settings.max_local_searches = 1;
    settings.max_evaluations = 16 + 16 * static_cast<int>(start.size());
    settings.initial_step = 0.02;
    settings.min_step = 1e-6;
    search_multistart(settings, context_.budget);
    return outer_objective.best;
  }

  void collect_designs(BilevelResult& designs) {
    const auto cost = [&](const InnerSolution& s) { return has_figure_ ? s.value : s.residual; };
    std::stable_sort(local_optima_.begin(), local_optima_.end(),
                     [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    if (capabilities_.has_convex_limits)
      std::stable_partition(local_optima_.begin(), local_optima_.end(), [&](const InnerSolution& optimum) {
        return max_limit_violation(optimum) <= limit_tolerance;
      });
    for (const InnerSolution& optimum : local_optima_) {
      const VectorX u = model_->recover_variables(optimum.u, optimum.unknowns);
      std::vector<VectorX>& list = optimum.residual < feasibility_tolerance ? designs.balanced : designs.others;
      const bool is_known =
          std::any_of(list.begin(), list.end(), [&](const VectorX& k) { return numerics::max_abs(k - u) < 1e-6; });
      if (!is_known && list.size() < 6) list.push_back(u);
    }
  }

  const SolverContext& context_;
  const DesignModel::Capabilities capabilities_;
  const VectorX& anchor_;
  bool has_conditions_, has_figure_;
  const ScaledObjective* objective_;
  std::optional<ConvexMassModel> model_;
  std::vector<int> geometric_limits_;
  const StartEndHandler& handle_start_end_;
  std::vector<VectorX> begun_;  ///< starts of searches for the figure
  bool is_finished_ = false, has_kinks_ = true;
  double figure_scale_ = 1, limit_margin_ = 0;
  std::vector<InnerSolution> local_optima_;
};

}  // namespace

BilevelResult search_bilevel(const SolverContext& context, const VectorX& anchor, const ScaledObjective* objective,
                             bool ignore_conditions, const StartEndHandler& handle_start_end) {
  return BilevelSearch(context, anchor, objective, ignore_conditions, handle_start_end).run();
}

}  // namespace balance::design
