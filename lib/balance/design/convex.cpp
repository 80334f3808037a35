#include "balance/design/convex.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/base/quadratic_program.hpp"
#include "balance/design/limits.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Value and bound agree if they differ by less than this part of the value, or of the value at the start.
constexpr double agreement = 1e-7, of_start = 1e-10;
constexpr int newton_steps = 30, bundle_steps = 400;
constexpr std::size_t most_cuts = 150;
/// Curvature that keeps the epigraph's variable near, in units of the objective.
constexpr double height_curvature = 0.1;
/// Limits of which more than this part of the bound is left need no tangent.
constexpr double far_from_limit = 0.1;

/// f(u) ≥ constant + slope · u for all u.
struct Tangent {
  double constant;
  VectorX slope;
};

class ConvexSearch {
 public:
  ConvexSearch(const Context& context, const FigureOfMerit& merit, const LinearConditions& conditions,
               const std::function<VectorX(const VectorX&)>& back, const VectorX& start)
      : context_(context), merit_(merit), conditions_(conditions), back_(back), n_(start.size()) {
    best_.u = start;
    best_.value = merit_(start, &slope_);
    best_.bound = merit_.lower_bound();
    const double before = std::abs(merit_(context.box.start(), nullptr));
    size_ = std::max({std::abs(best_.value), 1e-6 * before, 1e-300});
    round_off_ = merit_.round_off();
    scale_ = size_;
  }

  Optimum run() {
    add_tangent(best_.u, best_.value, slope_);
    keep_interior(best_.u);
    bundle_step();
    if (!done()) newton();
    // what is left is small beside the start: the programs' own round-off must be, too
    scale_ = std::max(std::abs(best_.value), 1e-6 * size_);
    for (int k = 0; k < bundle_steps && !done() && !context_.budget.spent(); ++k)
      if (!bundle_step()) break;
    conclude();
    return best_;
  }

 private:
  double tolerance() const { return std::max({agreement * std::abs(best_.value), of_start * size_, round_off_}); }
  bool done() const { return best_.value - best_.bound <= tolerance(); }

  /// A bound above the value by more than round-off contradicts the convexity that it rests on.
  void conclude() {
    if (!(best_.bound <= best_.value + tolerance())) best_.bound = std::numeric_limits<double>::quiet_NaN();
    best_.global = done();
    best_.bound = std::min(best_.bound, best_.value);
  }

  void add_tangent(const VectorX& u, double value, const VectorX& slope) {
    if (tangents_.size() >= most_cuts) tangents_.erase(tangents_.begin());
    tangents_.push_back({value - slope.dot(u), slope});
  }

  /// Tangents of the physical inequalities at u; each holds for every physical design.
  void add_physical(const VectorX& u) {
    if (context_.inequalities() == 0) return;
    VectorX g;
    MatrixX dg;
    context_.evaluate_inequalities(u, g, &dg);
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (k >= context_.physical.size() && g[k] > far_from_limit) continue;
      if (physical_.size() >= most_cuts) physical_.erase(physical_.begin());
      physical_.push_back({g[k] - dg.row(k).dot(u), dg.row(k).transpose()});
    }
  }

  /// Conditions, bounds and physical tangents for the first n of the program's variables.
  void constrain(QuadraticProgram& program, Eigen::Index variables, Eigen::Index more) const {
    const auto p = static_cast<Eigen::Index>(physical_.size());
    program.equalities.setZero(conditions_.a.rows(), variables);
    program.equalities.leftCols(n_) = conditions_.a;
    program.equal_to = conditions_.c;
    program.inequalities.setZero(2 * n_ + p + more, variables);
    program.at_least.setConstant(2 * n_ + p + more, -1);
    program.inequalities.topLeftCorner(n_, n_).setIdentity();
    program.inequalities.block(n_, 0, n_, n_) = -MatrixX::Identity(n_, n_);
    for (Eigen::Index k = 0; k < p; ++k) {
      program.inequalities.row(2 * n_ + k).head(n_) = physical_[static_cast<std::size_t>(k)].slope.transpose();
      program.at_least[2 * n_ + k] = -physical_[static_cast<std::size_t>(k)].constant;
    }
  }

  /// A candidate brought back onto the conditions. @return it is better
  bool accept(const VectorX& candidate, bool& admissible) {
    VectorX u = back_(clipped(candidate));
    admissible = context_.allows(u);
    add_physical(u);
    if (!admissible && !draw_in(u)) return false;
    keep_interior(u);
    VectorX slope;
    const double value = merit_(u, &slope);
    if (!std::isfinite(value) || !slope.allFinite()) return false;
    add_tangent(u, value, slope);
    if (!(value < best_.value)) return false;
    best_.u = u;
    best_.value = value;
    slope_ = slope;
    return true;
  }

  /// The allowed point with the most left of its limits.
  void keep_interior(const VectorX& u) {
    if (context_.limits->size() == 0) return;
    VectorX g;
    context_.limits->evaluate(u, g, nullptr);
    if (!(min_coefficient(g) > left_)) return;
    left_ = min_coefficient(g);
    interior_ = u;
  }

  /// From beyond the limits towards that point, no farther than needed. Source: Veinott, The supporting hyperplane method for
  /// unimodal programming, Operations Research 15 (1967). @return it is allowed there
  bool draw_in(VectorX& u) const {
    if (interior_.size() == 0) return false;
    const auto between = [&, from = u](double part) { return back_(from + part * (interior_ - from)); };
    double outside = 0, inside = 1;
    while (inside - outside > 1e-9 * inside) {
      const double middle = (outside + inside) / 2;
      (context_.allows(between(middle)) ? inside : outside) = middle;
    }
    u = between(inside);
    return inside < 1 && context_.allows(u);
  }

  void newton() {
    for (int k = 0; k < newton_steps && !context_.budget.spent(); ++k) {
      QuadraticProgram program;
      program.hessian = positive(central_differences(
          [this](const VectorX& v) {
            VectorX slope;
            merit_(v, &slope);
            return slope;
          },
          best_.u, n_));
      if (!program.hessian.allFinite()) return;
      program.gradient = slope_ - program.hessian * best_.u;
      add_physical(best_.u);
      constrain(program, n_, 0);
      const auto optimum = solve(program);
      if (!optimum) return;
      VectorX step = optimum->x - best_.u;
      const double before = best_.value;
      bool admissible = false;
      for (int halving = 0; halving < 8 && !accept(best_.u + step, admissible); ++halving) step /= 2;
      if (!(best_.value < before - 1e-14 * std::abs(before))) return;
    }
  }

  /// Symmetric part with its eigenvalues kept above a small part of the largest.
  static MatrixX positive(const MatrixX& hessian) {
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
    program.hessian(n_, n_) = height_curvature;
    program.gradient = -program.hessian.col(n_) * (best_.value / scale_);
    program.gradient[n_] += 1;
    program.gradient.head(n_) = -curvature_ * best_.u;
    constrain(program, n_ + 1, cuts);
    const auto first = program.at_least.size() - cuts;
    for (Eigen::Index k = 0; k < cuts; ++k) {
      const Tangent& tangent = tangents_[static_cast<std::size_t>(k)];
      program.inequalities.row(first + k).head(n_) = -tangent.slope.transpose() / scale_;
      program.inequalities(first + k, n_) = 1;
      program.at_least[first + k] = tangent.constant / scale_;
    }
    const auto optimum = solve(program);
    if (!optimum) return false;
    take_bound(program, *optimum, cuts);
    if (done()) return true;
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
  void take_bound(const QuadraticProgram& program, const QuadraticOptimum& optimum, Eigen::Index cuts) {
    const VectorX& z = optimum.inequality_multipliers;
    const auto first = program.at_least.size() - cuts, p = static_cast<Eigen::Index>(physical_.size());
    const double sum = z.tail(cuts).sum();
    if (!(sum > 0)) return;
    double constant = scale_ * optimum.equality_multipliers.dot(conditions_.c) / sum;
    VectorX slope = -scale_ * (conditions_.a.transpose() * optimum.equality_multipliers) / sum;
    for (Eigen::Index k = 0; k < cuts; ++k) {
      constant += z[first + k] / sum * tangents_[static_cast<std::size_t>(k)].constant;
      slope += z[first + k] / sum * tangents_[static_cast<std::size_t>(k)].slope;
    }
    for (Eigen::Index k = 0; k < p; ++k) {
      constant -= scale_ * z[2 * n_ + k] / sum * physical_[static_cast<std::size_t>(k)].constant;
      slope -= scale_ * z[2 * n_ + k] / sum * physical_[static_cast<std::size_t>(k)].slope;
    }
    best_.bound = std::max(best_.bound, constant - slope.lpNorm<1>());
  }

  const Context& context_;
  const FigureOfMerit& merit_;
  const LinearConditions& conditions_;
  const std::function<VectorX(const VectorX&)>& back_;
  Eigen::Index n_;
  Optimum best_;
  VectorX slope_;
  double size_;  ///< of the objective where the search began
  double round_off_;
  double scale_;  ///< of what the programs are solved in
  double curvature_ = 1;
  std::vector<Tangent> tangents_;
  std::vector<Tangent> physical_;  ///< ≥ 0
  VectorX interior_;               ///< empty: none is known
  double left_ = 0;
};

}  // namespace

Optimum minimise_convex(const Context& context, const FigureOfMerit& merit, const LinearConditions& conditions,
                        const std::function<VectorX(const VectorX&)>& back, const VectorX& start) {
  return ConvexSearch(context, merit, conditions, back, start).run();
}

}  // namespace balance::designing
