#include "balance/foundation/numerics/quadratic_program.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace balance {

namespace {

/// With y = Lᵀ x, H = L Lᵀ, the optimum is the point of the feasible set that is nearest to −L⁻¹ g.
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
    right_.resize(total_);
    right_ << program.equality_values, program.inequality_lower_bounds;
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
  double slack(Eigen::Index i) const { return normals_.col(i).dot(y_) - right_[i]; }
  double tolerance(Eigen::Index i) const { return 1e-13 * (std::abs(right_[i]) + normal_norms_[i] * (1 + y_.norm())); }

  Eigen::Index find_most_violated_constraint() const {
    Eigen::Index worst = -1;
    double most = 0;
    for (Eigen::Index i = equalities_; i < total_; ++i) {
      if (normal_norms_[i] == 0) continue;
      const double violation = -slack(i) - tolerance(i);
      if (violation / normal_norms_[i] > most && !is_active(i)) most = violation / normal_norms_[i], worst = i;
    }
    return worst;
  }

  bool is_active(Eigen::Index i) const {
    for (const Eigen::Index a : active_)
      if (a == i) return true;
    return false;
  }

  /// Moves to the nearest point that meets constraint p too, dropping constraints that hold it back.
  bool add_constraint(Eigen::Index p) {
    if (std::abs(slack(p)) <= tolerance(p) && p >= equalities_) return true;
    for (std::size_t guard = 0; guard < 4 * static_cast<std::size_t>(total_) + 10; ++guard) {
      const double sign = p < equalities_ && slack(p) > 0 ? -1 : 1;  // an equality is approached from its side
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
      const bool blocked = !(slope > 1e-20 * normal.squaredNorm());
      if (blocked && p < equalities_ &&
          std::abs(slack(p)) <= 1e-9 * (std::abs(right_[p]) + normal_norms_[p] * (1 + y_.norm())))
        return true;  // follows from the others
      double limit = std::numeric_limits<double>::infinity();
      Eigen::Index drop = -1;
      for (Eigen::Index k = 0; k < q; ++k) {
        const Eigen::Index a = active_[static_cast<std::size_t>(k)];
        if (a >= equalities_ && r[k] > 0 && multipliers_[a] / r[k] < limit) limit = multipliers_[a] / r[k], drop = k;
      }
      const double full = blocked ? std::numeric_limits<double>::infinity() : std::abs(slack(p)) / slope;
      const double t = std::min(limit, full);
      if (!std::isfinite(t)) return false;
      if (!blocked) y_ += t * z;
      for (Eigen::Index k = 0; k < q; ++k) multipliers_[active_[static_cast<std::size_t>(k)]] -= t * r[k];
      multipliers_[p] += sign * t;
      if (full <= limit) {
        active_.push_back(p);
        return true;
      }
      multipliers_[active_[static_cast<std::size_t>(drop)]] = 0;
      active_.erase(active_.begin() + drop);
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
  MatrixX normals_;  ///< columns
  VectorX right_, normal_norms_, multipliers_;
  std::vector<Eigen::Index> active_;
};

}  // namespace

std::optional<QuadraticOptimum> solve_quadratic_program(const QuadraticProgram& program) {
  return GoldfarbIdnaniSolver(program).run();
}

}  // namespace balance
