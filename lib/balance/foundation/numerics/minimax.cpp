#include "balance/foundation/numerics/minimax.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace balance::numerics {
namespace {

constexpr double predicted_decrease_tolerance = 2e-9;  // of the value; a step must promise more
constexpr double epigraph_curvature = 1e-6;            // of the epigraph variable; makes the program strictly convex
constexpr double min_trust_radius = 1e-7;
constexpr double active_function_threshold =
    0.3;  // of the initial maximum: functions further below the current maximum are left out of a step
constexpr int max_minimax_iterations = 150;
constexpr int max_cutting_rounds = 30;  // rounds of half-spaces in one step
constexpr std::size_t max_cutting_planes = 400;

class MinimaxSolver {
 public:
  MinimaxSolver(const MinimaxProblem& problem, const VectorX& start)
      : problem_(problem), metric_factors_(problem.metric), x_(start) {}

  MinimaxResult run() {
    const VectorX initial_values = problem_.values(x_);
    if (initial_values.size() == 0) return {x_, std::numeric_limits<double>::infinity()};
    scale_ = max_coefficient(initial_values);
    if (!(scale_ > 0)) return {x_, scale_};
    f_ = initial_values / scale_;
    jacobian_ = problem_.jacobian(x_) / scale_;
    reset_hessian();
    for (int iteration = 0; iteration < max_minimax_iterations && trust_radius_ > min_trust_radius; ++iteration) {
      VectorX weights;
      const auto step = solve_subproblem(weights);
      if (!step || !(predicted_decrease(*step) > predicted_decrease_tolerance * std::min(1.0, trust_radius_))) {
        if (is_hessian_reset_) break;
        reset_hessian();  // the curvature learnt so far may be the obstacle
        continue;
      }
      if (!line_search(*step, weights)) {
        trust_radius_ = 0.25 * max_abs(*step);
        reset_hessian();
      }
    }
    return {x_, max_coefficient(f_) * scale_};
  }

 private:
  /// Back to the metric, scaled for a first step of half the set's size.
  void reset_hessian() {
    const VectorX descent_direction = metric_factors_.solve(jacobian_.row(max_index(f_)).transpose());
    hessian_ = problem_.metric * std::max(2 * max_abs(descent_direction), 1e-12);
    is_hessian_reset_ = true;
  }

  double predicted_decrease(const VectorX& step) const {
    return max_coefficient(f_) - max_coefficient(f_ + jacobian_ * step);
  }

  std::vector<Eigen::Index> near_active_functions() const {
    const double max_value = max_coefficient(f_);
    std::vector<Eigen::Index> active;
    for (Eigen::Index i = 0; i < f_.size(); ++i)
      if (f_[i] > max_value - active_function_threshold) active.push_back(i);
    return active;
  }

  /// Variables: the step and the bound of all functions, measured from the current maximum.
  QuadraticProgram make_subproblem(const std::vector<Eigen::Index>& active) const {
    const Eigen::Index n = x_.size(), m = static_cast<Eigen::Index>(active.size());
    const auto c = static_cast<Eigen::Index>(cutting_planes_.size());
    QuadraticProgram p;
    p.hessian = MatrixX::Zero(n + 1, n + 1);
    p.hessian.topLeftCorner(n, n) = hessian_;
    p.hessian(n, n) = epigraph_curvature;
    p.gradient = VectorX::Unit(n + 1, n);
    p.equalities.resize(0, n + 1);
    p.equality_values.resize(0);
    p.inequalities = MatrixX::Zero(m + c + 2 * n, n + 1);
    p.inequality_lower_bounds = VectorX::Constant(m + c + 2 * n, -trust_radius_);
    const double max_value = max_coefficient(f_);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Index function = active[static_cast<std::size_t>(i)];
      p.inequalities.row(i).head(n) = -jacobian_.row(function);
      p.inequalities(i, n) = 1;
      p.inequality_lower_bounds[i] = f_[function] - max_value;
    }
    for (Eigen::Index i = 0; i < c; ++i) {
      const VectorX& normal = cutting_planes_[static_cast<std::size_t>(i)];
      p.inequalities.row(m + i).head(n) = -normal.transpose();
      p.inequality_lower_bounds[m + i] = normal.dot(x_) - 1;
    }
    p.inequalities.block(m + c, 0, n, n).setIdentity();
    p.inequalities.block(m + c + n, 0, n, n) = -MatrixX::Identity(n, n);
    return p;
  }

  /// @param weights multipliers of the functions in the Lagrangian
  std::optional<VectorX> solve_subproblem(VectorX& weights) {
    const std::vector<Eigen::Index> active = near_active_functions();
    if (cutting_planes_.size() > max_cutting_planes)
      cutting_planes_.erase(cutting_planes_.begin(), cutting_planes_.begin() + max_cutting_planes / 2);
    for (int round = 0; round < max_cutting_rounds; ++round) {
      const auto optimum = solve_quadratic_program(make_subproblem(active));
      if (!optimum) return std::nullopt;
      const VectorX candidate = x_ + optimum->x.head(x_.size());
      const std::vector<VectorX> new_planes = problem_.cutting_planes(candidate);
      cutting_planes_.insert(cutting_planes_.end(), new_planes.begin(), new_planes.end());
      if (!new_planes.empty() && round + 1 < max_cutting_rounds) continue;
      weights = VectorX::Zero(f_.size());
      for (std::size_t i = 0; i < active.size(); ++i)
        weights[active[i]] = optimum->inequality_multipliers[static_cast<Eigen::Index>(i)];
      const double gauge = problem_.gauge(candidate);
      return gauge > 1 ? VectorX(candidate / gauge - x_) : VectorX(candidate - x_);
    }
    return std::nullopt;
  }

  /// Backtracks until the value decreases sufficiently. @return whether it does
  bool line_search(const VectorX& step, const VectorX& weights) {
    constexpr int max_backtracks = 9;
    constexpr double sufficient_decrease = 1e-4;
    const double value = max_coefficient(f_), predicted = predicted_decrease(step);
    for (int k = 0; k <= max_backtracks; ++k) {
      const double step_length = std::ldexp(1.0, -k);
      const VectorX candidate = x_ + step_length * step;
      const VectorX values = problem_.values(candidate) / scale_;
      if (values.size() == 0 || !(max_coefficient(values) <= value - sufficient_decrease * step_length * predicted))
        continue;
      const MatrixX jacobian = problem_.jacobian(candidate) / scale_;
      update_hessian(step_length * step, (jacobian - jacobian_).transpose() * weights);
      if (k == 0) trust_radius_ = std::min(1.0, 2 * trust_radius_);
      x_ = candidate;
      f_ = values;
      jacobian_ = jacobian;
      return true;
    }
    return false;
  }

  void update_hessian(const VectorX& step, VectorX gradient_change) {
    if (is_hessian_reset_ && step.dot(gradient_change) > 0)
      hessian_ =
          problem_.metric * (gradient_change.dot(metric_factors_.solve(gradient_change)) / step.dot(gradient_change));
    const VectorX Bs = hessian_ * step;
    const double sBs = step.dot(Bs), sy = step.dot(gradient_change);
    if (!(sBs > 0)) return;
    if (sy < 0.2 * sBs) {
      const double theta = 0.8 * sBs / (sBs - sy);
      gradient_change = theta * gradient_change + (1 - theta) * Bs;
    }
    hessian_ += gradient_change * gradient_change.transpose() / step.dot(gradient_change) - Bs * Bs.transpose() / sBs;
    hessian_ = (hessian_ + hessian_.transpose()).eval() / 2;
    is_hessian_reset_ = false;
  }

  const MinimaxProblem& problem_;
  Eigen::LLT<MatrixX> metric_factors_;  ///< factors of the metric
  VectorX x_, f_;
  MatrixX jacobian_, hessian_;
  std::vector<VectorX> cutting_planes_;
  double scale_ = 1, trust_radius_ = 0.5;
  bool is_hessian_reset_ = true;
};

}  // namespace

MinimaxResult solve_minimax(const MinimaxProblem& problem, const VectorX& start) {
  return MinimaxSolver(problem, start).run();
}

}  // namespace balance::numerics
