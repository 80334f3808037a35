#include "balance/synthesis/design/convex_optimum.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Value and bound agree if they differ by less than this part of the value, or of the value at the start.
constexpr double convex_gap_tolerance = 1e-7, start_gap_tolerance = 1e-10;
constexpr int max_newton_iterations = 30, max_bundle_iterations = 400;
constexpr std::size_t max_cuts = 150;
/// Curvature that keeps the epigraph's variable near, in units of the objective.
constexpr double epigraph_curvature = 0.1;
/// Limits of which more than this part of the bound is left need no tangent.
constexpr double inactive_limit_threshold = 0.1;

/// f(u) ≥ constant + slope · u for all u.
struct CuttingPlane {
  double constant;
  VectorX gradient;
};

class BundleNewtonMethod {
 public:
  BundleNewtonMethod(const SolverContext& context, const ScaledObjective& merit, const LinearConditions& conditions,
                     const std::function<VectorX(const VectorX&)>& back, const VectorX& start)
      : context_(context), objective_(merit), conditions_(conditions), back_(back), n_(start.size()) {
    best_.u = start;
    best_.value = objective_(start, &slope_);
    best_.lower_bound = objective_.lower_bound();
    const double before = std::abs(objective_(context.scaling.start(), nullptr));
    size_ = std::max({std::abs(best_.value), 1e-6 * before, 1e-300});
    round_off_ = objective_.round_off();
    scale_ = size_;
  }

  Optimum run() {
    add_objective_cut(best_.u, best_.value, slope_);
    update_interior_point(best_.u);
    bundle_step();
    if (!is_converged()) newton();
    // what is left is small beside the start: the programs' own round-off must be, too
    scale_ = std::max(std::abs(best_.value), 1e-6 * size_);
    for (int k = 0; k < max_bundle_iterations && !is_converged() && !context_.budget.is_spent(); ++k)
      if (!bundle_step()) break;
    conclude();
    return best_;
  }

 private:
  double tolerance() const {
    return std::max({convex_gap_tolerance * std::abs(best_.value), start_gap_tolerance * size_, round_off_});
  }
  bool is_converged() const { return best_.value - best_.lower_bound <= tolerance(); }

  /// A bound above the value by more than round-off contradicts the convexity that it rests on.
  void conclude() {
    if (!(best_.lower_bound <= best_.value + tolerance())) best_.lower_bound = std::numeric_limits<double>::quiet_NaN();
    best_.is_global = is_converged();
    best_.lower_bound = std::min(best_.lower_bound, best_.value);
  }

  void add_objective_cut(const VectorX& u, double value, const VectorX& slope) {
    if (tangents_.size() >= max_cuts) tangents_.erase(tangents_.begin());
    tangents_.push_back({value - slope.dot(u), slope});
  }

  /// Tangents of the physical inequalities at u; each holds for every physical design.
  void add_constraint_cuts(const VectorX& u) {
    if (context_.inequality_count() == 0) return;
    VectorX g;
    MatrixX dg;
    context_.evaluate_inequalities(u, g, &dg);
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (k >= context_.physical_constraints.size() && g[k] > inactive_limit_threshold) continue;
      if (physical_.size() >= max_cuts) physical_.erase(physical_.begin());
      physical_.push_back({g[k] - dg.row(k).dot(u), dg.row(k).transpose()});
    }
  }

  /// Conditions, bounds and physical tangents for the first n of the program's variables.
  void fill_constraints(QuadraticProgram& program, Eigen::Index variables, Eigen::Index more) const {
    const auto p = static_cast<Eigen::Index>(physical_.size());
    program.equalities.setZero(conditions_.a.rows(), variables);
    program.equalities.leftCols(n_) = conditions_.a;
    program.equality_values = conditions_.c;
    program.inequalities.setZero(2 * n_ + p + more, variables);
    program.inequality_lower_bounds.setConstant(2 * n_ + p + more, -1);
    program.inequalities.topLeftCorner(n_, n_).setIdentity();
    program.inequalities.block(n_, 0, n_, n_) = -MatrixX::Identity(n_, n_);
    for (Eigen::Index k = 0; k < p; ++k) {
      program.inequalities.row(2 * n_ + k).head(n_) = physical_[static_cast<std::size_t>(k)].gradient.transpose();
      program.inequality_lower_bounds[2 * n_ + k] = -physical_[static_cast<std::size_t>(k)].constant;
    }
  }

  /// A candidate brought back onto the conditions. @return it is better
  bool accept(const VectorX& candidate, bool& admissible) {
    VectorX u = back_(clip_to_unit_box(candidate));
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
    slope_ = slope;
    return true;
  }

  /// The allowed point with the most left of its limits.
  void update_interior_point(const VectorX& u) {
    if (context_.limits->size() == 0) return;
    VectorX g;
    context_.limits->evaluate(u, g, nullptr);
    if (!(min_coefficient(g) > left_)) return;
    left_ = min_coefficient(g);
    interior_ = u;
  }

  /// From beyond the limits towards that point, no farther than needed. Source: Veinott, The supporting hyperplane method for
  /// unimodal programming, Operations Research 15 (1967). @return it is allowed there
  bool move_to_boundary(VectorX& u) const {
    if (interior_.size() == 0) return false;
    const auto between = [&, from = u](double part) { return back_(from + part * (interior_ - from)); };
    double outside = 0, inside = 1;
    while (inside - outside > 1e-9 * inside) {
      const double middle = (outside + inside) / 2;
      (context_.is_admissible(between(middle)) ? inside : outside) = middle;
    }
    u = between(inside);
    return inside < 1 && context_.is_admissible(u);
  }

  void newton() {
    for (int k = 0; k < max_newton_iterations && !context_.budget.is_spent(); ++k) {
      QuadraticProgram program;
      program.hessian = make_positive_definite(central_difference_jacobian(
          [this](const VectorX& v) {
            VectorX slope;
            objective_(v, &slope);
            return slope;
          },
          best_.u, n_));
      if (!program.hessian.allFinite()) return;
      program.gradient = slope_ - program.hessian * best_.u;
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

  /// Symmetric part with its eigenvalues kept above a small part of the largest.
  static MatrixX make_positive_definite(const MatrixX& hessian) {
    if (!hessian.allFinite()) return hessian;
    const SymmetricEigenSolver solver((hessian + hessian.transpose()) / 2);
    const double floor = std::max(1e-9 * max_abs(solver.eigenvalues()), 1e-12);
    return solver.eigenvectors() * solver.eigenvalues().cwiseMax(floor).asDiagonal() *
           solver.eigenvectors().transpose();
  }

  /// Minimises the tangents' maximum near the best point; its multipliers give a bound.
  bool bundle_step() {
    const auto cuts = static_cast<Eigen::Index>(tangents_.size());
    QuadraticProgram program;
    program.hessian = MatrixX::Identity(n_ + 1, n_ + 1) * curvature_;
    program.hessian(n_, n_) = epigraph_curvature;
    program.gradient = -program.hessian.col(n_) * (best_.value / scale_);
    program.gradient[n_] += 1;
    program.gradient.head(n_) = -curvature_ * best_.u;
    fill_constraints(program, n_ + 1, cuts);
    const auto first = program.inequality_lower_bounds.size() - cuts;
    for (Eigen::Index k = 0; k < cuts; ++k) {
      const CuttingPlane& tangent = tangents_[static_cast<std::size_t>(k)];
      program.inequalities.row(first + k).head(n_) = -tangent.gradient.transpose() / scale_;
      program.inequalities(first + k, n_) = 1;
      program.inequality_lower_bounds[first + k] = tangent.constant / scale_;
    }
    const auto optimum = solve_quadratic_program(program);
    if (!optimum) return false;
    update_lower_bound(program, *optimum, cuts);
    if (is_converged()) return true;
    const VectorX candidate = optimum->x.head(n_);
    const double before = best_.value;
    bool admissible = false;
    const bool better = accept(candidate, admissible);
    const double promised = before - scale_ * optimum->x[n_];
    if (better && before - best_.value > 0.3 * promised)
      curvature_ = std::max(curvature_ / 3, 1e-8);
    else if (!better)
      curvature_ = std::min(curvature_ * 1.3, 1e6);
    return true;
  }

  /// Lagrangian of the problem with the program's multipliers, at its least over the box.
  void update_lower_bound(const QuadraticProgram& program, const QuadraticOptimum& optimum, Eigen::Index cuts) {
    const VectorX& z = optimum.inequality_multipliers;
    const auto first = program.inequality_lower_bounds.size() - cuts, p = static_cast<Eigen::Index>(physical_.size());
    const double sum = z.tail(cuts).sum();
    if (!(sum > 0)) return;
    double constant = scale_ * optimum.equality_multipliers.dot(conditions_.c) / sum;
    VectorX slope = -scale_ * (conditions_.a.transpose() * optimum.equality_multipliers) / sum;
    for (Eigen::Index k = 0; k < cuts; ++k) {
      constant += z[first + k] / sum * tangents_[static_cast<std::size_t>(k)].constant;
      slope += z[first + k] / sum * tangents_[static_cast<std::size_t>(k)].gradient;
    }
    for (Eigen::Index k = 0; k < p; ++k) {
      constant -= scale_ * z[2 * n_ + k] / sum * physical_[static_cast<std::size_t>(k)].constant;
      slope -= scale_ * z[2 * n_ + k] / sum * physical_[static_cast<std::size_t>(k)].gradient;
    }
    best_.lower_bound = std::max(best_.lower_bound, constant - slope.lpNorm<1>());
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  const LinearConditions& conditions_;
  const std::function<VectorX(const VectorX&)>& back_;
  Eigen::Index n_;
  Optimum best_;
  VectorX slope_;
  double size_;  ///< of the objective where the search began
  double round_off_;
  double scale_;  ///< of what the programs are solved in
  double curvature_ = 1;
  std::vector<CuttingPlane> tangents_;
  std::vector<CuttingPlane> physical_;  ///< ≥ 0
  VectorX interior_;                    ///< empty: none is known
  double left_ = 0;
};

}  // namespace

Optimum minimise_convex(const SolverContext& context, const ScaledObjective& merit, const LinearConditions& conditions,
                        const std::function<VectorX(const VectorX&)>& back, const VectorX& start) {
  return BundleNewtonMethod(context, merit, conditions, back, start).run();
}

}  // namespace balance::design
