#include "balance/synthesis/design/geometry_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/bilevel_search.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/multistart.hpp"
#include "balance/synthesis/design/optimum_search.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace balance::design {

/// Numbers at one geometry, and which of several are better.
struct TrialDesign {
  VectorX u;                 ///< all numbers
  bool is_feasible = false;  ///< no obstacle
  bool is_balanced = false;
  double figure = std::numeric_limits<double>::quiet_NaN();  ///< the objective
  double residual =
      std::numeric_limits<double>::quiet_NaN();  ///< norm of what is left of the goal at the equations' samples
};

class TrialEvaluator {
 public:
  /// @param equations of the goal, or none
  /// @param merit null: none
  TrialEvaluator(const SolverContext& context, const NonlinearSystem& equations, const ScaledObjective* merit);

  /// The objective comes before the conditions where these cannot be met.
  bool is_figure_first() const { return objective_ != nullptr && !context_.problem.objective->is_secondary; }
  /// Balanced before not, then by the objective, or by what is left.
  double cost(const TrialDesign& trial) const;
  void update_best(TrialDesign& best, TrialDesign trial) const;

  /// By the conditions of its own geometry, derived anew.
  bool is_balanced(const VectorX& u) const;
  /// All numbers as they stand.
  TrialDesign evaluate(const VectorX& u) const;
  /// At the lengths of u: the other numbers solved for by themselves.
  TrialDesign solve_at_geometry(const VectorX& u) const;

 private:
  void evaluate_figures(TrialDesign& trial) const;

  const SolverContext& context_;
  const NonlinearSystem& equations_;
  const ScaledObjective* objective_;
  std::vector<int> others_;  ///< numbers that do not change the geometry
};

namespace {

/// Points of the box from which an anchor is looked for.
constexpr int max_start_samples = 200;
/// Part of half a length's range within which it may be meant to be a special one.
constexpr double length_ratio_tolerance = 1e-5;

}  // namespace

std::optional<VectorX> find_feasible_start(const SolverContext& context, std::string& reason) {
  const auto good = [&](const VectorX& u, std::string& why) {
    why = context.infeasibility_reason(u);
    if (!why.empty()) return false;
    const Conditions conditions = context.conditions_at(u);
    if (conditions.status != ConditionsStatus::done) why = conditions.reason;
    return conditions.status == ConditionsStatus::done;
  };
  const VectorX start = context.scaling.start();
  if (good(start, reason)) return start;
  // nearer ones first, the other numbers as they are
  const std::vector<int> lengths = geometric_variables(context);
  const auto points =
      low_discrepancy_points(max_start_samples, static_cast<int>(lengths.size()), context.problem.search.seed);
  for (std::size_t k = 0; k < points.size() && !context.budget.is_spent(); ++k) {
    VectorX u = start;
    const double part = static_cast<double>(k + 1) / static_cast<double>(points.size());
    for (std::size_t i = 0; i < lengths.size(); ++i)
      u[lengths[i]] = std::clamp(
          start[lengths[i]] + part * (points[k][static_cast<Eigen::Index>(i)] - start[lengths[i]]), -1.0, 1.0);
    std::string why;
    if (good(u, why)) return u;
  }
  return std::nullopt;
}

std::optional<VectorX> snap_to_length_ratios(const SolverContext& context, const VectorX& u) {
  const VectorX numbers = collect_geometry(context.mechanism(u), context.options.loose_springs);
  const VectorX x = context.scaling.to_variables(u);
  VectorX moved = u;
  for (const int i : geometric_variables(context)) {
    const double half = context.scaling.half_width()[i];
    double nearest = length_ratio_tolerance * half;
    if (!(half > 0)) continue;
    for (const double other : numbers)
      for (const double ratio : {1.0, 2.0, 0.5, 1.5, 2.0 / 3, 3.0, 1.0 / 3, 4.0 / 3, 0.75}) {
        const double off = std::abs(std::abs(other) * ratio - std::abs(x[i]));
        // the number itself is among them
        if (off >= nearest || off <= 1e-15 * std::abs(x[i])) continue;
        nearest = off;
        moved[i] =
            std::clamp((std::copysign(std::abs(other) * ratio, x[i]) - context.scaling.centre()[i]) / half, -1.0, 1.0);
      }
  }
  return moved == u ? std::nullopt : std::optional<VectorX>(moved);
}

namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
/// Exact designs whose lengths are looked at, and joint descents for them besides the start's.
constexpr int max_exact_designs = 4, max_joint_starts = 12;
/// Of the designs that two levels find.
constexpr std::size_t max_bilevel_candidates = 3;
/// Lengths moved by this part of their range show whether designs exist around.
constexpr double neighbour_offset = 1e-3;

class GeometrySearch {
 public:
  GeometrySearch(const SolverContext& context, const VectorX& anchor, const NonlinearSystem& equations,
                 const ScaledObjective* merit)
      : context_(context),
        anchor_(anchor),
        equations_(equations),
        objective_(merit),
        trials_(context, equations, merit),
        lengths_(geometric_variables(context)),
        others_(inertial_variables(context)) {}

  GeometrySearchResult run() {
    TrialDesign best;
    const bool able = try_bilevel_search(best);
    if (!best.is_balanced)
      for (const VectorX& u : find_exact_designs()) {
        evaluate_candidate(best, u);
        if (objective_ == nullptr && best.is_balanced) break;
      }
    if (!best.is_balanced) trials_.update_best(best, solve_at_samples());
    if (objective_ != nullptr && best.is_balanced)
      best = improve_geometry(best, able && context_.limits->size() == context_.problem.convex_limit_count);
    if (!best.is_balanced) best = search_compromise(best);
    if (best.is_feasible && equations_.primary_rows == 0 && context_.limits->size() == 0) search_all_variables(best);
    return report(best);
  }

 private:
  /// @return the problem is of the kind that it is made for
  bool try_bilevel_search(TrialDesign& best) {
    const BilevelResult designs = search_bilevel(context_, anchor_, objective_, false);
    std::size_t looked = 0;
    for (const VectorX& u : designs.balanced) {
      if (best.is_balanced &&
          (objective_ == nullptr || ++looked >= max_bilevel_candidates || context_.budget.is_spent()))
        break;
      if (!context_.infeasibility_reason(u).empty()) continue;
      evaluate_candidate(best, equations_.primary_rows > 0
                                   ? solve_levenberg_marquardt(make_equations_near(context_, u, equations_), u).u
                                   : u);
      trials_.update_best(best, trials_.solve_at_geometry(u));
    }
    others_found_ = designs.others;
    return designs.is_applicable;
  }

  /// An exact design, or nearly one, as it stands and with the masses solved for.
  void evaluate_candidate(TrialDesign& best, const VectorX& u) const {
    trials_.update_best(best, trials_.evaluate(u));
    if (objective_ == nullptr && best.is_balanced) return;
    trials_.update_best(best, trials_.solve_at_geometry(u));
    if (const auto special = snap_to_length_ratios(context_, u); special && !best.is_balanced)
      trials_.update_best(best, trials_.solve_at_geometry(*special));
  }

  /// Joint Gauss–Newton on all numbers.
  std::vector<VectorX> find_exact_designs() {
    if (equations_.primary_rows == 0) return {anchor_};
    ExactSearchOptions effort;
    effort.starts.push_back(anchor_);
    for (const VectorX& u : prepare_starts()) effort.starts.push_back(u);
    effort.max_restarts = context_.problem.search.max_restarts;
    effort.max_solutions = objective_ == nullptr ? 1 : max_exact_designs;
    effort.is_usable = [this](const VectorX& u) {
      if (!context_.infeasibility_reason(u).empty()) return false;
      if (objective_ == nullptr || std::isfinite((*objective_)(u, nullptr))) return true;
      if (trials_.is_balanced(u)) valueless_ = u;
      return false;
    };
    ExactSolutions search = find_exact_solutions(context_, equations_, effort);
    best_descent_ = search.closest;
    for (VectorX& u : search.solutions)
      if (const VectorX better = solve_levenberg_marquardt(equations_, u).u; is_exact(context_, equations_, better))
        u = better;
    return search.solutions;
  }

  /// Lengths that fill their box, each with the other numbers that leave the least there: the best of them.
  std::vector<VectorX> prepare_starts() {
    std::vector<std::pair<double, VectorX>> points;
    const int count = 8 + 8 * static_cast<int>(lengths_.size());
    for (const VectorX& part :
         low_discrepancy_points(count, static_cast<int>(lengths_.size()), context_.problem.search.seed)) {
      if (context_.budget.is_spent()) break;
      VectorX u = anchor_;
      u(lengths_) = part;
      ++context_.budget.geometries;
      const LeastSquaresResult descent = solve_inertial_variables(u);
      if (descent.values.size() > 0 && context_.infeasibility_reason(descent.u).empty())
        points.emplace_back(descent.values.squaredNorm(), descent.u);
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> starts;
    for (std::size_t k = 0; k < std::min<std::size_t>(points.size(), max_joint_starts); ++k)
      starts.push_back(points[k].second);
    samples_ = std::move(points);
    return starts;
  }

  /// Gauss–Newton on the numbers that do not change the geometry, on the goal's rows at fixed samples.
  LeastSquaresResult solve_inertial_variables(const VectorX& u) const {
    NonlinearSystem part = equations_;
    part.evaluate = [this, &u](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      VectorX all = u;
      all(others_) = v;
      MatrixX slopes;
      if (!equations_.evaluate(all, values, jacobian != nullptr ? &slopes : nullptr)) return false;
      if (jacobian != nullptr) *jacobian = slopes(Eigen::all, others_);
      return true;
    };
    LeastSquaresResult descent = solve_levenberg_marquardt(part, u(others_), 30);
    VectorX all = u;
    all(others_) = descent.u;
    descent.u = all;
    return descent;
  }

  /// Where the joint search found nothing: the best of its samples, solved at their lengths.
  TrialDesign solve_at_samples() {
    TrialDesign best;
    trials_.update_best(best, trials_.solve_at_geometry(anchor_));
    for (std::size_t k = 0; k < std::min<std::size_t>(samples_.size(), max_joint_starts) && !best.is_balanced; ++k) {
      if (context_.budget.is_spent()) break;
      trials_.update_best(best, trials_.solve_at_geometry(samples_[k].second));
    }
    return best;
  }

  /// Designs exist at lengths around these, not only at them.
  bool has_neighbouring_designs(const TrialDesign& trial) const {
    for (const double by : {neighbour_offset, -neighbour_offset}) {
      VectorX u = trial.u;
      for (std::size_t k = 0; k < lengths_.size(); ++k) {
        double& value = u[lengths_[k]];
        value += value > 0.9 ? -neighbour_offset : value < -0.9 ? neighbour_offset : (k % 2 == 0 ? by : -by);
      }
      if (trials_.solve_at_geometry(u).is_balanced) return true;
    }
    return false;
  }

  /// Better lengths for an exact design.
  /// @param looked around already, where designs exist at all lengths: two levels do so where they know all limits
  TrialDesign improve_geometry(const TrialDesign& from, bool looked) {
    TrialDesign best = from;
    if (!has_neighbouring_designs(from)) {
      const NonlinearSystem here = make_equations_near(context_, from.u, equations_);
      const auto back = [&](const VectorX& u) { return solve_levenberg_marquardt(here, u).u; };
      const VectorX u = optimise_exact_solutions(context_, *objective_, here, back, {from.u}).u;
      trials_.update_best(best, trials_.evaluate(u));
      trials_.update_best(best, trials_.solve_at_geometry(best.u));
    } else if (!looked || context_.limits->size() > 0) {  // two levels know peaks by few samples
      search_lengths(
          best, [](const TrialDesign& trial) { return trial.is_balanced; }, looked);
    }
    return best;
  }

  /// Derivative-free over the lengths, from the best and from points that fill their box.
  /// @param near from the best alone, in small steps
  void search_lengths(TrialDesign& best, const std::function<bool(const TrialDesign&)>& counts, bool near = false) {
    MultistartSettings task;
    std::map<std::vector<double>, double> known;
    task.objective = [&](const VectorX& part) {
      const std::vector<double> key(part.begin(), part.end());
      if (const auto at_key = known.find(key); at_key != known.end()) return at_key->second;
      VectorX u = best.u;
      u(lengths_) = part;
      const TrialDesign trial = trials_.solve_at_geometry(u);
      const double value = trial.is_feasible && counts(trial) ? trials_.cost(trial) : no_value;
      if (std::isfinite(value)) trials_.update_best(best, trial);
      known[key] = value;
      return value;
    };
    task.starts = {best.u(lengths_)};
    const auto n = static_cast<int>(lengths_.size());
    if (!near)
      for (const VectorX& part : low_discrepancy_points(4 + 4 * n, n, context_.problem.search.seed))
        task.starts.push_back(part);
    const std::string& asked = context_.problem.search.local;
    task.method = asked == "cobyla" || asked == "sbplx" || asked == "bobyqa" ? asked : "bobyqa";
    task.max_local_searches = near ? 1 : 2;
    task.max_evaluations = std::min(context_.problem.search.max_evaluations, near ? 8 + 8 * n : 40 + 40 * n);
    if (near) task.initial_step = 0.01;
    task.min_step = 1e-5;
    search_multistart(task, context_.budget);
  }

  /// Without conditions all numbers may go down the figure's slopes at once.
  void search_all_variables(TrialDesign& best) const {
    if (objective_ == nullptr || !objective_->has_max_terms() || context_.budget.is_spent()) return;
    if (const auto end = minimise_max_terms_from(context_, *objective_, best.u))
      trials_.update_best(best, trials_.evaluate(*end));
  }

  /// The least that can be had without balance.
  TrialDesign search_compromise(TrialDesign best) {
    trials_.update_best(best, trials_.solve_at_geometry(anchor_));
    if (best_descent_.values.size() > 0) trials_.update_best(best, trials_.evaluate(best_descent_.u));
    for (const VectorX& u : others_found_) trials_.update_best(best, trials_.solve_at_geometry(u));
    BilevelResult designs;
    if (trials_.is_figure_first()) designs = search_bilevel(context_, anchor_, objective_, true);
    for (const VectorX& u : designs.balanced) trials_.update_best(best, trials_.solve_at_geometry(u));
    if (best.is_feasible && !designs.is_applicable) search_lengths(best, [](const TrialDesign&) { return true; });
    return best;
  }

  GeometrySearchResult report(const TrialDesign& best) const {
    GeometrySearchResult design;
    design.is_found = best.is_feasible;
    design.is_balanced = best.is_balanced;
    design.minimises_residual = !best.is_balanced && !trials_.is_figure_first();
    design.u = best.is_feasible ? best.u : anchor_;
    if (!best.is_balanced) design.balanced_without_value = valueless_;
    return design;
  }

  const SolverContext& context_;
  VectorX anchor_;
  const NonlinearSystem& equations_;
  const ScaledObjective* objective_;
  TrialEvaluator trials_;
  std::vector<int> lengths_, others_;
  std::optional<VectorX> valueless_;
  LeastSquaresResult best_descent_;
  std::vector<VectorX> others_found_;
  std::vector<std::pair<double, VectorX>> samples_;
};

}  // namespace

GeometrySearchResult search_geometry(const SolverContext& context, const VectorX& anchor,
                                     const NonlinearSystem& equations, const ScaledObjective* merit) {
  return GeometrySearch(context, anchor, equations, merit).run();
}

TrialEvaluator::TrialEvaluator(const SolverContext& context, const NonlinearSystem& equations,
                               const ScaledObjective* merit)
    : context_(context), equations_(equations), objective_(merit), others_(inertial_variables(context)) {}

double TrialEvaluator::cost(const TrialDesign& trial) const {
  if (trial.is_balanced) return objective_ != nullptr ? trial.figure : 0;
  return is_figure_first() ? trial.figure : trial.residual;
}

void TrialEvaluator::update_best(TrialDesign& best, TrialDesign trial) const {
  if (!trial.is_feasible || !std::isfinite(cost(trial))) return;
  const bool better = !best.is_feasible || (trial.is_balanced && !best.is_balanced) ||
                      (trial.is_balanced == best.is_balanced && cost(trial) < cost(best));
  if (better) best = std::move(trial);
}

TrialDesign TrialEvaluator::evaluate(const VectorX& u) const {
  TrialDesign trial;
  trial.u = u;
  trial.is_feasible = context_.is_physical(u) && context_.infeasibility_reason(u).empty();
  if (!trial.is_feasible) return trial;
  trial.is_balanced = is_balanced(u);
  evaluate_figures(trial);
  return trial;
}

bool TrialEvaluator::is_balanced(const VectorX& u) const {
  const Conditions conditions = context_.conditions_at(u);
  if (conditions.status != ConditionsStatus::done || !context_.is_admissible(u)) return false;
  if (conditions.parameter_rows() == 0) return true;
  const VectorX residual =
      scaled_residuals(conditions, term_values(context_.mechanism(u), context_.options.loose_springs))
          .head(conditions.parameter_rows());
  return max_abs(residual) < condition_tolerance;
}

void TrialEvaluator::evaluate_figures(TrialDesign& trial) const {
  if (objective_ != nullptr && !std::isfinite(trial.figure)) trial.figure = (*objective_)(trial.u, nullptr);
  VectorX values;
  trial.residual = equations_.primary_rows == 0                    ? 0
                   : equations_.evaluate(trial.u, values, nullptr) ? values.head(equations_.primary_rows).norm()
                                                                   : std::numeric_limits<double>::quiet_NaN();
}

TrialDesign TrialEvaluator::solve_at_geometry(const VectorX& u) const {
  TrialDesign trial;
  trial.u = u;
  if (!context_.infeasibility_reason(u).empty()) return trial;
  ++context_.budget.geometries;
  try {
    const VectorX x = context_.scaling.to_variables(u);
    const DesignProblem inner = make_fixed_geometry_problem(context_, x, context_.budget.remaining_time());
    const DesignOutcome outcome = solve_design(inner);
    if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::no_feasible_start) return trial;
    trial.is_balanced = outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::no_goal;
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const auto i = others_[k];
      const double half = context_.scaling.half_width()[i];
      trial.u[i] =
          half > 0
              ? std::clamp((outcome.x[static_cast<Eigen::Index>(k)] - context_.scaling.centre()[i]) / half, -1.0, 1.0)
              : 0;
    }
    trial.is_feasible = context_.is_admissible(trial.u);
    trial.figure = outcome.objective;
    evaluate_figures(trial);
  } catch (const SpecError&) {
    trial.is_feasible = false;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    trial.is_feasible = false;
  } catch (const DeadlineExceeded&) {
    trial.is_feasible = false;
  }
  return trial;
}

}  // namespace balance::design
