#include "balance/foundation/numerics/minimax.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace balance {
namespace {

constexpr double predicted_decrease_tolerance = 2e-9;  // of the value: what another step promises
constexpr double epigraph_curvature = 1e-6;  // of the largest function's bound, for a program that is strictly convex
constexpr double min_trust_radius = 1e-7;
constexpr double active_function_threshold =
    0.3;  // functions below the largest by more than this part of it are left out of a step
constexpr int max_minimax_iterations = 150;
constexpr int max_cutting_rounds = 30;  // of half-spaces in one step
constexpr std::size_t max_cutting_planes = 400;

class MinimaxSolver {
 public:
  MinimaxSolver(const MinimaxProblem& problem, const VectorX& start)
      : problem_(problem), solver_(problem.metric), x_(start) {}

  MinimaxResult run() {
    const VectorX first = problem_.values(x_);
    if (first.size() == 0) return {x_, std::numeric_limits<double>::infinity()};
    scale_ = max_coefficient(first);
    if (!(scale_ > 0)) return {x_, scale_};
    f_ = first / scale_;
    slopes_ = problem_.jacobian(x_) / scale_;
    reset_hessian();
    for (int step = 0; step < max_minimax_iterations && trust_radius_ > min_trust_radius; ++step) {
      VectorX weights;
      const auto way = solve_subproblem(weights);
      if (!way || !(predicted_decrease(*way) > predicted_decrease_tolerance * std::min(1.0, trust_radius_))) {
        if (is_hessian_reset_) break;
        reset_hessian();  // what was learnt of the curvature may be what stands in the way
        continue;
      }
      if (!line_search(*way, weights)) {
        trust_radius_ = 0.25 * max_abs(*way);
        reset_hessian();
      }
    }
    return {x_, max_coefficient(f_) * scale_};
  }

 private:
  /// A first step of half the set's size.
  void reset_hessian() {
    const VectorX downhill = solver_.solve(slopes_.row(max_index(f_)).transpose());
    hessian_ = problem_.metric * std::max(2 * max_abs(downhill), 1e-12);
    is_hessian_reset_ = true;
  }

  double predicted_decrease(const VectorX& way) const {
    return max_coefficient(f_) - max_coefficient(f_ + slopes_ * way);
  }

  std::vector<Eigen::Index> near_active_functions() const {
    const double most = max_coefficient(f_);
    std::vector<Eigen::Index> chosen;
    for (Eigen::Index i = 0; i < f_.size(); ++i)
      if (f_[i] > most - active_function_threshold) chosen.push_back(i);
    return chosen;
  }

  /// Over the step and the bound of all functions, which is counted from the present largest.
  QuadraticProgram make_subproblem(const std::vector<Eigen::Index>& pieces) const {
    const Eigen::Index n = x_.size(), m = static_cast<Eigen::Index>(pieces.size());
    const auto c = static_cast<Eigen::Index>(cuts_.size());
    QuadraticProgram p;
    p.hessian = MatrixX::Zero(n + 1, n + 1);
    p.hessian.topLeftCorner(n, n) = hessian_;
    p.hessian(n, n) = epigraph_curvature;
    p.gradient = VectorX::Unit(n + 1, n);
    p.equalities.resize(0, n + 1);
    p.equality_values.resize(0);
    p.inequalities = MatrixX::Zero(m + c + 2 * n, n + 1);
    p.inequality_lower_bounds = VectorX::Constant(m + c + 2 * n, -trust_radius_);
    const double most = max_coefficient(f_);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Index piece = pieces[static_cast<std::size_t>(i)];
      p.inequalities.row(i).head(n) = -slopes_.row(piece);
      p.inequalities(i, n) = 1;
      p.inequality_lower_bounds[i] = f_[piece] - most;
    }
    for (Eigen::Index i = 0; i < c; ++i) {
      const VectorX& normal = cuts_[static_cast<std::size_t>(i)];
      p.inequalities.row(m + i).head(n) = -normal.transpose();
      p.inequality_lower_bounds[m + i] = normal.dot(x_) - 1;
    }
    p.inequalities.block(m + c, 0, n, n).setIdentity();
    p.inequalities.block(m + c + n, 0, n, n) = -MatrixX::Identity(n, n);
    return p;
  }

  /// @param weights of the functions in the Lagrangian
  std::optional<VectorX> solve_subproblem(VectorX& weights) {
    const std::vector<Eigen::Index> pieces = near_active_functions();
    if (cuts_.size() > max_cutting_planes) cuts_.erase(cuts_.begin(), cuts_.begin() + max_cutting_planes / 2);
    for (int round = 0; round < max_cutting_rounds; ++round) {
      const auto optimum = solve_quadratic_program(make_subproblem(pieces));
      if (!optimum) return std::nullopt;
      const VectorX there = x_ + optimum->x.head(x_.size());
      const std::vector<VectorX> more = problem_.cutting_planes(there);
      cuts_.insert(cuts_.end(), more.begin(), more.end());
      if (!more.empty() && round + 1 < max_cutting_rounds) continue;
      weights = VectorX::Zero(f_.size());
      for (std::size_t i = 0; i < pieces.size(); ++i)
        weights[pieces[i]] = optimum->inequality_multipliers[static_cast<Eigen::Index>(i)];
      const double reach = problem_.gauge(there);
      return reach > 1 ? VectorX(there / reach - x_) : VectorX(there - x_);
    }
    return std::nullopt;
  }

  /// As far as the value falls enough. @return whether it did
  bool line_search(const VectorX& way, const VectorX& weights) {
    constexpr int max_backtracks = 9;
    constexpr double sufficient_decrease = 1e-4;
    const double before = max_coefficient(f_), promise = predicted_decrease(way);
    for (int k = 0; k <= max_backtracks; ++k) {
      const double part = std::ldexp(1.0, -k);
      const VectorX there = x_ + part * way;
      const VectorX values = problem_.values(there) / scale_;
      if (values.size() == 0 || !(max_coefficient(values) <= before - sufficient_decrease * part * promise)) continue;
      const MatrixX slopes = problem_.jacobian(there) / scale_;
      update_hessian(part * way, (slopes - slopes_).transpose() * weights);
      if (k == 0) trust_radius_ = std::min(1.0, 2 * trust_radius_);
      x_ = there;
      f_ = values;
      slopes_ = slopes;
      return true;
    }
    return false;
  }

  void update_hessian(const VectorX& step, VectorX change) {
    if (is_hessian_reset_ && step.dot(change) > 0)
      hessian_ = problem_.metric * (change.dot(solver_.solve(change)) / step.dot(change));
    const VectorX image = hessian_ * step;
    const double bend = step.dot(image), seen = step.dot(change);
    if (!(bend > 0)) return;
    if (seen < 0.2 * bend) {
      const double share = 0.8 * bend / (bend - seen);
      change = share * change + (1 - share) * image;
    }
    hessian_ += change * change.transpose() / step.dot(change) - image * image.transpose() / bend;
    hessian_ = (hessian_ + hessian_.transpose()).eval() / 2;
    is_hessian_reset_ = false;
  }

  const MinimaxProblem& problem_;
  Eigen::LLT<MatrixX> solver_;  ///< of the metric
  VectorX x_, f_;
  MatrixX slopes_, hessian_;
  std::vector<VectorX> cuts_;
  double scale_ = 1, trust_radius_ = 0.5;
  bool is_hessian_reset_ = true;
};

}  // namespace

MinimaxResult solve_minimax(const MinimaxProblem& problem, const VectorX& start) {
  return MinimaxSolver(problem, start).run();
}

}  // namespace balance
