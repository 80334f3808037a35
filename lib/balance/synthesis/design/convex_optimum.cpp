#include "balance/synthesis/design/convex_optimum.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Gap between value and bound that proves optimality, relative to the value or to the value at the start.
constexpr double convex_gap_tolerance = 1e-7, start_gap_tolerance = 1e-10;
constexpr int max_newton_iterations = 30, max_bundle_iterations = 400;
constexpr std::size_t max_cuts = 150;
/// Curvature of the proximal term of the epigraph variable, in units of the objective.
constexpr double epigraph_curvature = 0.1;
/// Limits with a larger relative margin need no tangents.
constexpr double inactive_limit_threshold = 0.1;

/// f(u) ≥ constant + slope · u for all u.
struct CuttingPlane {
  double constant;
  VectorX gradient;
};

class BundleNewtonMethod {
 public:
  BundleNewtonMethod(const SolverContext& context, const ScaledObjective& objective, const LinearConditions& conditions,
                     const std::function<VectorX(const VectorX&)>& restore, const VectorX& start)
      : context_(context), objective_(objective), conditions_(conditions), restore_(restore), n_(start.size()) {
    best_.u = start;
    best_.value = objective_(start, &gradient_);
    best_.lower_bound = objective_.lower_bound();
    const double before = std::abs(objective_(context.scaling.start(), nullptr));
    start_scale_ = std::max({std::abs(best_.value), 1e-6 * before, 1e-300});
    round_off_ = objective_.round_off();
    objective_scale_ = start_scale_;
  }

  Optimum run() {
    add_objective_cut(best_.u, best_.value, gradient_);
    update_interior_point(best_.u);
    bundle_step();
    if (!is_converged()) newton();
    // Near the optimum the value may be small compared with the start; so must be the programs' round-off.
    objective_scale_ = std::max(std::abs(best_.value), 1e-6 * start_scale_);
    for (int k = 0; k < max_bundle_iterations && !is_converged() && !context_.budget.is_spent(); ++k)
      if (!bundle_step()) break;
    conclude();
    return best_;
  }

 private:
  double tolerance() const {
    return std::max({convex_gap_tolerance * std::abs(best_.value), start_gap_tolerance * start_scale_, round_off_});
  }
  bool is_converged() const { return best_.value - best_.lower_bound <= tolerance(); }

  /// A bound above the value by more than round-off contradicts the assumed convexity.
  void conclude() {
    if (!(best_.lower_bound <= best_.value + tolerance())) best_.lower_bound = std::numeric_limits<double>::quiet_NaN();
    best_.is_global = is_converged();
    best_.lower_bound = std::min(best_.lower_bound, best_.value);
  }

  void add_objective_cut(const VectorX& u, double value, const VectorX& slope) {
    if (objective_cuts_.size() >= max_cuts) objective_cuts_.erase(objective_cuts_.begin());
    objective_cuts_.push_back({value - slope.dot(u), slope});
  }

  /// Adds tangents of the inequalities at u; all admissible designs satisfy them.
  void add_constraint_cuts(const VectorX& u) {
    if (context_.inequality_count() == 0) return;
    VectorX g;
    MatrixX dg;
    context_.evaluate_inequalities(u, g, &dg);
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (k >= context_.physical_constraints.size() && g[k] > inactive_limit_threshold) continue;
      if (constraint_cuts_.size() >= max_cuts) constraint_cuts_.erase(constraint_cuts_.begin());
      constraint_cuts_.push_back({g[k] - dg.row(k).dot(u), dg.row(k).transpose()});
    }
  }

  /// Conditions, bounds and tangents of the inequalities for the first n variables of the program.
  void fill_constraints(numerics::QuadraticProgram& program, Eigen::Index variables, Eigen::Index extra_rows) const {
    const auto p = static_cast<Eigen::Index>(constraint_cuts_.size());
    program.equalities.setZero(conditions_.matrix.rows(), variables);
    program.equalities.leftCols(n_) = conditions_.matrix;
    program.equality_values = conditions_.rhs;
    program.inequalities.setZero(2 * n_ + p + extra_rows, variables);
    program.inequality_lower_bounds.setConstant(2 * n_ + p + extra_rows, -1);
    program.inequalities.topLeftCorner(n_, n_).setIdentity();
    program.inequalities.block(n_, 0, n_, n_) = -MatrixX::Identity(n_, n_);
    for (Eigen::Index k = 0; k < p; ++k) {
      program.inequalities.row(2 * n_ + k).head(n_) =
          constraint_cuts_[static_cast<std::size_t>(k)].gradient.transpose();
      program.inequality_lower_bounds[2 * n_ + k] = -constraint_cuts_[static_cast<std::size_t>(k)].constant;
    }
  }

  /// Projects a candidate onto the conditions. @return whether it is better
  bool accept(const VectorX& candidate, bool& admissible) {
    VectorX u = restore_(clip_to_unit_box(candidate));
    admissible = context_.is_admissible(u);
    add_constraint_cuts(u);
    if (!admissible && !move_to_boundary(u)) return false;
    update_interior_point(u);
    VectorX slope;
    const double value = objective_(u, &slope);
    if (!std::isfinite(value) || !slope.allFinite()) return false;
    add_objective_cut(u, value, slope);
    if (!(value < best_.value)) return false;
    best_.u = u;
    best_.value = value;
    gradient_ = slope;
    return true;
  }

  /// Keeps the admissible point with the largest margin of the limits.
  void update_interior_point(const VectorX& u) {
    if (context_.limits->size() == 0) return;
    VectorX g;
    context_.limits->evaluate(u, g, nullptr);
    if (!(numerics::min_coefficient(g) > interior_margin_)) return;
    interior_margin_ = numerics::min_coefficient(g);
    interior_point_ = u;
  }

  /// Moves a point outside the limits towards the interior point, no farther than necessary. Source: Veinott, The
  /// supporting hyperplane method for unimodal programming, Operations Research 15 (1967). @return whether the result
  /// is admissible
  bool move_to_boundary(VectorX& u) const {
    if (interior_point_.size() == 0) return false;
    const auto interpolate = [&, from = u](double fraction) {
      return restore_(from + fraction * (interior_point_ - from));
    };
    double outside = 0, inside = 1;
    while (inside - outside > 1e-9 * inside) {
      const double middle = (outside + inside) / 2;
      (context_.is_admissible(interpolate(middle)) ? inside : outside) = middle;
    }
    u = interpolate(inside);
    return inside < 1 && context_.is_admissible(u);
  }

  void newton() {
    for (int k = 0; k < max_newton_iterations && !context_.budget.is_spent(); ++k) {
      numerics::QuadraticProgram program;
      program.hessian = make_positive_definite(central_difference_jacobian(
          [this](const VectorX& v) {
            VectorX slope;
            objective_(v, &slope);
            return slope;
          },
          best_.u, n_));
      if (!program.hessian.allFinite()) return;
      program.gradient = gradient_ - program.hessian * best_.u;
      add_constraint_cuts(best_.u);
      fill_constraints(program, n_, 0);
      const auto optimum = solve_quadratic_program(program);
      if (!optimum) return;
      VectorX step = optimum->x - best_.u;
      const double before = best_.value;
      bool admissible = false;
      for (int halving = 0; halving < 8 && !accept(best_.u + step, admissible); ++halving) step /= 2;
      if (!(best_.value < before - 1e-14 * std::abs(before))) return;
    }
  }

  /// The symmetric part, with eigenvalues raised to at least a small fraction of the largest.
  static MatrixX make_positive_definite(const MatrixX& hessian) {
    if (!hessian.allFinite()) return hessian;
    const numerics::SymmetricEigenSolver solver((hessian + hessian.transpose()) / 2);
    const double floor = std::max(1e-9 * numerics::max_abs(solver.eigenvalues()), 1e-12);
    return solver.eigenvectors() * solver.eigenvalues().cwiseMax(floor).asDiagonal() *
           solver.eigenvectors().transpose();
  }

  /// Minimises the maximum of the tangents near the best point; the multipliers give a lower bound.
  bool bundle_step() {
    const auto cuts = static_cast<Eigen::Index>(objective_cuts_.size());
    numerics::QuadraticProgram program;
    program.hessian = MatrixX::Identity(n_ + 1, n_ + 1) * curvature_;
    program.hessian(n_, n_) = epigraph_curvature;
    program.gradient = -program.hessian.col(n_) * (best_.value / objective_scale_);
    program.gradient[n_] += 1;
    program.gradient.head(n_) = -curvature_ * best_.u;
    fill_constraints(program, n_ + 1, cuts);
    const auto first = program.inequality_lower_bounds.size() - cuts;
    for (Eigen::Index k = 0; k < cuts; ++k) {
      const CuttingPlane& cut = objective_cuts_[static_cast<std::size_t>(k)];
      program.inequalities.row(first + k).head(n_) = -cut.gradient.transpose() / objective_scale_;
      program.inequalities(first + k, n_) = 1;
      program.inequality_lower_bounds[first + k] = cut.constant / objective_scale_;
    }
    const auto optimum = solve_quadratic_program(program);
    if (!optimum) return false;
    update_lower_bound(program, *optimum, cuts);
    if (is_converged()) return true;
    const VectorX candidate = optimum->x.head(n_);
    const double before = best_.value;
    bool admissible = false;
    const bool better = accept(candidate, admissible);
    const double predicted_decrease = before - objective_scale_ * optimum->x[n_];
    if (better && before - best_.value > 0.3 * predicted_decrease)
      curvature_ = std::max(curvature_ / 3, 1e-8);
    else if (!better)
      curvature_ = std::min(curvature_ * 1.3, 1e6);
    return true;
  }

  /// Minimises the Lagrangian with the program's multipliers over the box.
  void update_lower_bound(const numerics::QuadraticProgram& program, const numerics::QuadraticOptimum& optimum,
                          Eigen::Index cuts) {
    const VectorX& z = optimum.inequality_multipliers;
    const auto first = program.inequality_lower_bounds.size() - cuts,
               p = static_cast<Eigen::Index>(constraint_cuts_.size());
    const double sum = z.tail(cuts).sum();
    if (!(sum > 0)) return;
    double constant = objective_scale_ * optimum.equality_multipliers.dot(conditions_.rhs) / sum;
    VectorX slope = -objective_scale_ * (conditions_.matrix.transpose() * optimum.equality_multipliers) / sum;
    for (Eigen::Index k = 0; k < cuts; ++k) {
      constant += z[first + k] / sum * objective_cuts_[static_cast<std::size_t>(k)].constant;
      slope += z[first + k] / sum * objective_cuts_[static_cast<std::size_t>(k)].gradient;
    }
    for (Eigen::Index k = 0; k < p; ++k) {
      constant -= objective_scale_ * z[2 * n_ + k] / sum * constraint_cuts_[static_cast<std::size_t>(k)].constant;
      slope -= objective_scale_ * z[2 * n_ + k] / sum * constraint_cuts_[static_cast<std::size_t>(k)].gradient;
    }
    best_.lower_bound = std::max(best_.lower_bound, constant - slope.lpNorm<1>());
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  const LinearConditions& conditions_;
  const std::function<VectorX(const VectorX&)>& restore_;
  Eigen::Index n_;
  Optimum best_;
  VectorX gradient_;
  double start_scale_;  ///< of the objective at the start
  double round_off_;
  double objective_scale_;  ///< unit of the objective in the programs
  double curvature_ = 1;
  std::vector<CuttingPlane> objective_cuts_;
  std::vector<CuttingPlane> constraint_cuts_;  ///< ≥ 0
  VectorX interior_point_;                     ///< empty: unknown
  double interior_margin_ = 0;
};

}  // namespace

Optimum minimise_convex(const SolverContext& context, const ScaledObjective& objective,
                        const LinearConditions& conditions, const std::function<VectorX(const VectorX&)>& restore,
                        const VectorX& start) {
  return BundleNewtonMethod(context, objective, conditions, restore, start).run();
}

}  // namespace balance::design
