#include "balance/foundation/numerics/quadratic_program.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace balance::numerics {

namespace {

/// With y = Lᵀ x and H = L Lᵀ, the optimum is the feasible point nearest to −L⁻¹ g.
class GoldfarbIdnaniSolver {
 public:
  explicit GoldfarbIdnaniSolver(const QuadraticProgram& program)
      : equalities_(program.equalities.rows()), total_(equalities_ + program.inequalities.rows()) {
    const Eigen::LLT<MatrixX> cholesky(program.hessian);
    l_ = cholesky.matrixL();
    y_ = -l_.triangularView<Eigen::Lower>().solve(program.gradient);
    MatrixX rows(total_, y_.size());
    rows << program.equalities, program.inequalities;
    normals_ = l_.triangularView<Eigen::Lower>().solve(rows.transpose());
    bounds_.resize(total_);
    bounds_ << program.equality_values, program.inequality_lower_bounds;
    normal_norms_ = normals_.colwise().norm().transpose();
    multipliers_ = VectorX::Zero(total_);
  }

  std::optional<QuadraticOptimum> run() {
    for (Eigen::Index e = 0; e < equalities_; ++e)
      if (!add_constraint(e)) return std::nullopt;
    const auto limit = 50 * (total_ + y_.size()) + 100;
    for (Eigen::Index iteration = 0; iteration < limit; ++iteration) {
      const Eigen::Index worst = find_most_violated_constraint();
      if (worst < 0) return finish();
      if (!add_constraint(worst)) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  double slack(Eigen::Index i) const { return normals_.col(i).dot(y_) - bounds_[i]; }
  double tolerance(Eigen::Index i) const { return 1e-13 * (std::abs(bounds_[i]) + normal_norms_[i] * (1 + y_.norm())); }

  Eigen::Index find_most_violated_constraint() const {
    Eigen::Index worst = -1;
    double max_violation = 0;
    for (Eigen::Index i = equalities_; i < total_; ++i) {
      if (normal_norms_[i] == 0) continue;
      const double violation = -slack(i) - tolerance(i);
      if (violation / normal_norms_[i] > max_violation && !is_active(i))
        max_violation = violation / normal_norms_[i], worst = i;
    }
    return worst;
  }

  bool is_active(Eigen::Index i) const {
    for (const Eigen::Index a : active_)
      if (a == i) return true;
    return false;
  }

  /// Moves to the nearest point that also satisfies constraint p, dropping constraints that block it. @return false if
  /// there is none
  bool add_constraint(Eigen::Index p) {
    if (std::abs(slack(p)) <= tolerance(p) && p >= equalities_) return true;
    for (std::size_t iteration = 0; iteration < 4 * static_cast<std::size_t>(total_) + 10; ++iteration) {
      const double sign = p < equalities_ && slack(p) > 0 ? -1 : 1;  // approaches an equality from the current side
      const VectorX normal = sign * normals_.col(p);
      const auto q = static_cast<Eigen::Index>(active_.size());
      VectorX z = normal, r(q);
      if (q > 0) {
        const MatrixX active = normals_(Eigen::all, active_);
        const Eigen::HouseholderQR<MatrixX> qr(active);
        VectorX projected = qr.householderQ().transpose() * normal;
        r = qr.matrixQR().topRows(q).triangularView<Eigen::Upper>().solve(projected.head(q));
        projected.head(q).setZero();
        z = qr.householderQ() * projected;
      }
      const double slope = z.squaredNorm();
      const bool is_dependent = !(slope > 1e-20 * normal.squaredNorm());
      if (is_dependent && p < equalities_ &&
          std::abs(slack(p)) <= 1e-9 * (std::abs(bounds_[p]) + normal_norms_[p] * (1 + y_.norm())))
        return true;  // implied by the others
      double max_dual_step = std::numeric_limits<double>::infinity();
      Eigen::Index dropped = -1;
      for (Eigen::Index k = 0; k < q; ++k) {
        const Eigen::Index a = active_[static_cast<std::size_t>(k)];
        if (a >= equalities_ && r[k] > 0 && multipliers_[a] / r[k] < max_dual_step)
          max_dual_step = multipliers_[a] / r[k], dropped = k;
      }
      const double full_step = is_dependent ? std::numeric_limits<double>::infinity() : std::abs(slack(p)) / slope;
      const double step = std::min(max_dual_step, full_step);
      if (!std::isfinite(step)) return false;
      if (!is_dependent) y_ += step * z;
      for (Eigen::Index k = 0; k < q; ++k) multipliers_[active_[static_cast<std::size_t>(k)]] -= step * r[k];
      multipliers_[p] += sign * step;
      if (full_step <= max_dual_step) {
        active_.push_back(p);
        return true;
      }
      multipliers_[active_[static_cast<std::size_t>(dropped)]] = 0;
      active_.erase(active_.begin() + dropped);
    }
    return false;
  }

  QuadraticOptimum finish() const {
    return {l_.transpose().triangularView<Eigen::Upper>().solve(y_), multipliers_.head(equalities_),
            multipliers_.tail(total_ - equalities_).cwiseMax(0)};
  }

  Eigen::Index equalities_, total_;
  MatrixX l_;
  VectorX y_;
  MatrixX normals_;  ///< one column per constraint
  VectorX bounds_, normal_norms_, multipliers_;
  std::vector<Eigen::Index> active_;
};

}  // namespace

std::optional<QuadraticOptimum> solve_quadratic_program(const QuadraticProgram& program) {
  return GoldfarbIdnaniSolver(program).run();
}

}  // namespace balance::numerics
