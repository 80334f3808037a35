#include "balance/foundation/numerics/underdetermined_system.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace balance::numerics {

namespace {

// Numbers are relative to the largest component of the least-norm solution, or to its largest violation of a bound.
constexpr double multiplier_threshold = 1e-9;  // of constraints that determine the solution; multipliers are of order 1
constexpr double excess_round_off = 1e-10;     // smaller excesses over bounds are none
constexpr double null_space_round_off = 1e-13;         // of entries of orthonormal vectors; smaller ones are zero
constexpr double constraint_slacks[] = {1e-11, 1e-9};  // let the last programs have an interior; removed by polish()
constexpr double max_polish_step = 1e-6, max_polish_violation = 1e-9;
/// Weights of the proximal terms. Small ones cross flat slopes, the last one removes round-off.
constexpr double proximal_weights[] = {1e-2, 1e-4, 1e-6, 1e-8, 1e-4, 1e-2};

/// One-sided constraints row · z ≥ bound − relaxation, with their meaning for x = x0 + Z z.
struct ConstraintRow {
  ActiveBound bound;
  VectorX normal;           ///< in z
  double limit = 0;         ///< normal · z ≥ limit, without excess or peak
  double excess_share = 0;  ///< of the excess, by which the limit is lowered
  bool is_peak() const {
    return bound.kind == ActiveBound::Kind::lowest_peak || bound.kind == ActiveBound::Kind::highest_peak;
  }
  double violation(const VectorX& z) const { return limit - normal.dot(z); }
};

struct LinearOptimum {
  VectorX z, multipliers;
};

class BoundedSolver {
 public:
  BoundedSolver(const UnderdeterminedSystem& system, SolutionNorm norm) : norm_(norm) {
    const Eigen::Index rank = system.matrix.rows(), n = system.matrix.cols();
    const SingularValueDecomposition svd(system.matrix, Eigen::ComputeThinU | Eigen::ComputeFullV);
    null_space_ = svd.matrixV().rightCols(n - rank).unaryExpr(
        [](double x) { return std::abs(x) < null_space_round_off ? 0 : x; });
    least_norm_ = svd.matrixV().leftCols(rank) *
                  (svd.matrixU().transpose() * system.right_hand_side).cwiseQuotient(svd.singularValues());
    double violation = 0;
    for (Eigen::Index i = 0; i < n; ++i)
      violation = std::max({violation, system.lower[i] - least_norm_[i], least_norm_[i] - system.upper[i]});
    has_violation_ = violation > 0;
    scale_ = std::max(max_abs(least_norm_), violation);
    if (!(scale_ > 0)) return;
    least_norm_ /= scale_;
    for (Eigen::Index i = 0; i < n; ++i) {
      const VectorX row = null_space_.row(i);
      const double x0 = least_norm_[i], share = system.excess_scale[i];
      using Kind = ActiveBound::Kind;
      if (std::isfinite(system.lower[i]))
        rows_.push_back({{i, Kind::lower}, row, system.lower[i] / scale_ - x0, share});
      if (std::isfinite(system.upper[i]))
        rows_.push_back({{i, Kind::upper}, -row, x0 - system.upper[i] / scale_, share});
      if (norm == SolutionNorm::maximum) {
        rows_.push_back({{i, Kind::lowest_peak}, row, -x0, 0});
        rows_.push_back({{i, Kind::highest_peak}, -row, x0, 0});
      }
    }
    is_active_.assign(rows_.size(), false);
  }

  BoundedSolution solve() {
    if (!(scale_ > 0) || (!has_violation_ && (norm_ == SolutionNorm::euclidean || null_space_.cols() == 0)))
      return finish(VectorX::Zero(null_space_.cols()));
    if (null_space_.cols() == 0) {
      find_excess(VectorX());
      return finish(VectorX());
    }
    std::optional<VectorX> z = minimise_norm(0);
    if (!z) {
      z = minimise_excess();
      if (norm_ == SolutionNorm::euclidean)
        if (const std::optional<VectorX> nearest = minimise_norm_with_slack()) z = nearest;
    }
    if (norm_ == SolutionNorm::maximum) {
      z = minimise_peak();
      if (const std::optional<VectorX> nearest = minimise_norm_with_slack()) z = nearest;
    }
    polish(*z);
    return finish(*z);
  }

 private:
  double limit(const ConstraintRow& row, double slack) const {
    return row.limit - row.excess_share * excess_ - (row.is_peak() ? peak_ : 0) - slack;
  }

  /// The least norm within bounds and peak. @return std::nullopt if there is no solution
  std::optional<VectorX> minimise_norm(double slack) {
    const Eigen::Index n = null_space_.cols();
    QuadraticProgram program{MatrixX::Identity(n, n), VectorX::Zero(n), MatrixX(0, n), VectorX(), {}, {}};
    const std::vector<std::size_t> used = assemble(program, 0, false, slack);
    const std::optional<QuadraticOptimum> optimum = solve_quadratic_program(program);
    if (!optimum) return std::nullopt;
    for (const std::size_t r : used)  // what no z changes is not part of the program
      if (rows_[r].normal.isZero(0) && limit(rows_[r], slack) > 0) return std::nullopt;
    mark_active(used, optimum->inequality_multipliers);
    return optimum->x;
  }

  /// At a vertex of the constraints, round-off may leave no solution.
  std::optional<VectorX> minimise_norm_with_slack() {
    for (const double slack : constraint_slacks)
      if (std::optional<VectorX> z = minimise_norm(slack)) return z;
    return std::nullopt;
  }

  VectorX minimise_excess() {
    std::fill(is_active_.begin(), is_active_.end(), false);
    const LinearOptimum optimum = minimise_last(false);
    find_excess(optimum.z);
    return optimum.z;
  }

  VectorX minimise_peak() {
    std::vector<bool> of_excess(rows_.size(), false);
    if (excess_ > 0) of_excess = is_active_;
    is_active_ = of_excess;
    const LinearOptimum optimum = minimise_last(true);
    peak_ = max_abs(least_norm_ + null_space_ * optimum.z);
    return optimum.z;
  }

  void find_excess(const VectorX& z) {
    excess_ = 0;
    for (const ConstraintRow& row : rows_)
      if (!row.is_peak()) excess_ = std::max(excess_, row.violation(z) / row.excess_share);
    if (excess_ < excess_round_off) excess_ = 0;
  }

  /// The least excess or peak τ, by the proximal point algorithm on (z, τ).
  LinearOptimum minimise_last(bool is_peak) {
    const Eigen::Index n = null_space_.cols() + 1;
    VectorX point = VectorX::Zero(n), multipliers;
    std::vector<std::size_t> used;
    for (const double weight : proximal_weights) {
      QuadraticProgram program{weight * MatrixX::Identity(n, n), -weight * point, MatrixX(0, n), VectorX(), {}, {}};
      program.gradient[n - 1] += 1;
      used = assemble(program, is_peak ? 2 : 1, true, constraint_slacks[0]);
      const std::optional<QuadraticOptimum> optimum = solve_quadratic_program(program);
      if (!optimum) continue;
      point = optimum->x;
      multipliers = optimum->inequality_multipliers;
    }
    if (multipliers.size() > 0) mark_active(used, multipliers);
    return {point.head(n - 1), multipliers};
  }

  /// Constraints of a program. @param of_last 0: excess and peak have values; 1: the last unknown is the excess; 2: the
  /// peak  @return the rows used
  std::vector<std::size_t> assemble(QuadraticProgram& program, int of_last, bool has_last, double slack) const {
    std::vector<std::size_t> used;
    for (std::size_t r = 0; r < rows_.size(); ++r)
      if (!rows_[r].is_peak() || of_last == 2 || (of_last == 0 && peak_ > 0)) used.push_back(r);
    const auto count = static_cast<Eigen::Index>(used.size());
    program.inequalities.setZero(count, program.gradient.size());
    program.inequality_lower_bounds.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const ConstraintRow& row = rows_[used[static_cast<std::size_t>(i)]];
      program.inequalities.row(i).head(row.normal.size()) = row.normal.transpose();
      const double last = of_last == 1 ? row.excess_share : of_last == 2 && row.is_peak() ? 1 : 0;
      if (has_last) program.inequalities(i, program.gradient.size() - 1) = last;
      program.inequality_lower_bounds[i] =
          of_last == 1 || (of_last == 2 && row.is_peak()) ? row.limit : limit(row, slack);
    }
    return used;
  }

  void mark_active(const std::vector<std::size_t>& used, const VectorX& multipliers) {
    for (std::size_t i = 0; i < used.size(); ++i)
      if (multipliers[static_cast<Eigen::Index>(i)] > multiplier_threshold) is_active_[used[i]] = true;
  }

  /// Solves the equations of the active constraints, in which excess and peak are unknowns, if that changes little.
  void polish(VectorX& z) {
    std::vector<const ConstraintRow*> active;
    for (std::size_t r = 0; r < rows_.size(); ++r)
      if (is_active_[r]) active.push_back(&rows_[r]);
    const Eigen::Index n = z.size(), count = static_cast<Eigen::Index>(active.size());
    if (count == 0) return;
    // z = Nᵀ μ, N z + excess_share · excess + peak = limit, and μ is orthogonal to the coefficients of excess and peak
    MatrixX system = MatrixX::Zero(n + count + 2, n + count + 2);
    VectorX rhs = VectorX::Zero(n + count + 2);
    system.topLeftCorner(n, n).setIdentity();
    for (Eigen::Index i = 0; i < count; ++i) {
      const ConstraintRow& row = *active[static_cast<std::size_t>(i)];
      system.block(0, n + i, n, 1) = -row.normal;
      system.block(n + i, 0, 1, n) = row.normal.transpose();
      rhs[n + i] = row.limit;
      const double of_excess = excess_ > 0 ? row.excess_share : 0, of_peak = row.is_peak() ? 1 : 0;
      system(n + i, n + count) = system(n + count, n + i) = of_excess;
      system(n + i, n + count + 1) = system(n + count + 1, n + i) = of_peak;
    }
    CompleteOrthogonalDecomposition factors;
    factors.setThreshold(1e-11);
    factors.compute(system);
    const VectorX solution = factors.solve(rhs);
    const VectorX polished = solution.head(n);
    const double excess = excess_ > 0 ? solution[n + count] : 0;
    const double peak = peak_ > 0 ? solution[n + count + 1] : 0;
    if (!solution.allFinite() || max_abs(polished - z) > max_polish_step) return;
    for (const ConstraintRow& row : rows_)
      if (row.violation(polished) > row.excess_share * excess + (row.is_peak() ? peak : 0) + max_polish_violation)
        return;
    z = polished;
    excess_ = excess;
  }

  BoundedSolution finish(const VectorX& z) const {
    BoundedSolution solution;
    solution.x = least_norm_;
    if (z.size() > 0) solution.x += null_space_ * z;
    if (scale_ > 0) solution.x *= scale_;
    solution.peak = max_abs(solution.x);
    solution.excess = excess_ * scale_;
    for (std::size_t r = 0; r < rows_.size(); ++r)
      if (is_active_[r]) solution.active.push_back(rows_[r].bound);
    return solution;
  }

  SolutionNorm norm_;
  MatrixX null_space_;
  VectorX least_norm_;
  double scale_ = 0;
  bool has_violation_ = false;
  std::vector<ConstraintRow> rows_;
  std::vector<bool> is_active_;
  double excess_ = 0, peak_ = 0;  ///< 0: not yet determined, or none
};

}  // namespace

BoundedSolution solve_bounded(const UnderdeterminedSystem& system, SolutionNorm norm) {
  return BoundedSolver(system, norm).solve();
}

}  // namespace balance::numerics
