#include "balance/timing/minimax.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/base/quadratic_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace balance {
namespace {

constexpr double enough = 2e-9;        // of the value: what another step promises
constexpr double no_curvature = 1e-6;  // of the largest function's bound, for a program that is strictly convex
constexpr double least_trust = 1e-7;
constexpr double largest_part = 0.3;  // functions below the largest by more than this part of it are left out of a step
constexpr int most_minimax_steps = 150;
constexpr int most_rounds = 30;  // of half-spaces in one step
constexpr std::size_t most_cuts = 400;

class MinimaxSearch {
 public:
  MinimaxSearch(const MinimaxProblem& problem, const VectorX& start)
      : problem_(problem), solver_(problem.metric), x_(start) {}

  Minimax run() {
    const VectorX first = problem_.values(x_);
    if (first.size() == 0) return {x_, std::numeric_limits<double>::infinity()};
    scale_ = max_coefficient(first);
    if (!(scale_ > 0)) return {x_, scale_};
    f_ = first / scale_;
    slopes_ = problem_.slopes(x_) / scale_;
    forget();
    for (int step = 0; step < most_minimax_steps && trust_ > least_trust; ++step) {
      VectorX weights;
      const auto way = promising_way(weights);
      if (!way || !(promised(*way) > enough * std::min(1.0, trust_))) {
        if (fresh_) break;
        forget();  // what was learnt of the curvature may be what stands in the way
        continue;
      }
      if (!go(*way, weights)) {
        trust_ = 0.25 * max_abs(*way);
        forget();
      }
    }
    return {x_, max_coefficient(f_) * scale_};
  }

 private:
  /// A first step of half the set's size.
  void forget() {
    const VectorX downhill = solver_.solve(slopes_.row(max_index(f_)).transpose());
    hessian_ = problem_.metric * std::max(2 * max_abs(downhill), 1e-12);
    fresh_ = true;
  }

  double promised(const VectorX& way) const { return max_coefficient(f_) - max_coefficient(f_ + slopes_ * way); }

  std::vector<Eigen::Index> large_ones() const {
    const double most = max_coefficient(f_);
    std::vector<Eigen::Index> chosen;
    for (Eigen::Index i = 0; i < f_.size(); ++i)
      if (f_[i] > most - largest_part) chosen.push_back(i);
    return chosen;
  }

  /// Over the step and the bound of all functions, which is counted from the present largest.
  QuadraticProgram program(const std::vector<Eigen::Index>& pieces) const {
    const Eigen::Index n = x_.size(), m = static_cast<Eigen::Index>(pieces.size());
    const auto c = static_cast<Eigen::Index>(cuts_.size());
    QuadraticProgram p;
    p.hessian = MatrixX::Zero(n + 1, n + 1);
    p.hessian.topLeftCorner(n, n) = hessian_;
    p.hessian(n, n) = no_curvature;
    p.gradient = VectorX::Unit(n + 1, n);
    p.equalities.resize(0, n + 1);
    p.equal_to.resize(0);
    p.inequalities = MatrixX::Zero(m + c + 2 * n, n + 1);
    p.at_least = VectorX::Constant(m + c + 2 * n, -trust_);
    const double most = max_coefficient(f_);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Index piece = pieces[static_cast<std::size_t>(i)];
      p.inequalities.row(i).head(n) = -slopes_.row(piece);
      p.inequalities(i, n) = 1;
      p.at_least[i] = f_[piece] - most;
    }
    for (Eigen::Index i = 0; i < c; ++i) {
      const VectorX& normal = cuts_[static_cast<std::size_t>(i)];
      p.inequalities.row(m + i).head(n) = -normal.transpose();
      p.at_least[m + i] = normal.dot(x_) - 1;
    }
    p.inequalities.block(m + c, 0, n, n).setIdentity();
    p.inequalities.block(m + c + n, 0, n, n) = -MatrixX::Identity(n, n);
    return p;
  }

  /// @param weights of the functions in the Lagrangian
  std::optional<VectorX> promising_way(VectorX& weights) {
    const std::vector<Eigen::Index> pieces = large_ones();
    if (cuts_.size() > most_cuts) cuts_.erase(cuts_.begin(), cuts_.begin() + most_cuts / 2);
    for (int round = 0; round < most_rounds; ++round) {
      const auto optimum = solve(program(pieces));
      if (!optimum) return std::nullopt;
      const VectorX there = x_ + optimum->x.head(x_.size());
      const std::vector<VectorX> more = problem_.cuts(there);
      cuts_.insert(cuts_.end(), more.begin(), more.end());
      if (!more.empty() && round + 1 < most_rounds) continue;
      weights = VectorX::Zero(f_.size());
      for (std::size_t i = 0; i < pieces.size(); ++i)
        weights[pieces[i]] = optimum->inequality_multipliers[static_cast<Eigen::Index>(i)];
      const double reach = problem_.reach(there);
      return reach > 1 ? VectorX(there / reach - x_) : VectorX(there - x_);
    }
    return std::nullopt;
  }

  /// As far as the value falls enough. @return whether it did
  bool go(const VectorX& way, const VectorX& weights) {
    constexpr int halvings = 9;
    constexpr double of_promise = 1e-4;
    const double before = max_coefficient(f_), promise = promised(way);
    for (int k = 0; k <= halvings; ++k) {
      const double part = std::ldexp(1.0, -k);
      const VectorX there = x_ + part * way;
      const VectorX values = problem_.values(there) / scale_;
      if (values.size() == 0 || !(max_coefficient(values) <= before - of_promise * part * promise)) continue;
      const MatrixX slopes = problem_.slopes(there) / scale_;
      learn(part * way, (slopes - slopes_).transpose() * weights);
      if (k == 0) trust_ = std::min(1.0, 2 * trust_);
      x_ = there;
      f_ = values;
      slopes_ = slopes;
      return true;
    }
    return false;
  }

  void learn(const VectorX& step, VectorX change) {
    if (fresh_ && step.dot(change) > 0)
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
    fresh_ = false;
  }

  const MinimaxProblem& problem_;
  Eigen::LLT<MatrixX> solver_;  ///< of the metric
  VectorX x_, f_;
  MatrixX slopes_, hessian_;
  std::vector<VectorX> cuts_;
  double scale_ = 1, trust_ = 0.5;
  bool fresh_ = true;
};

}  // namespace

Minimax minimise_largest(const MinimaxProblem& problem, const VectorX& start) {
  return MinimaxSearch(problem, start).run();
}

}  // namespace balance
