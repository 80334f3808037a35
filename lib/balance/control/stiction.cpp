#include "balance/control/stiction.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double least_norm_weight = 1e-12;  // of the least-norm term that chooses among λ that hold equally well
constexpr double relative_acceleration_tolerance = 1e-9;  // part of the terms of w beyond which w is not zero
constexpr double response_epsilon = 1e-24;  // response, against the largest, of a joint that forces do not move

/// Minimum of ½ zᵀB z − pᵀz within −bound.backward ≤ z ≤ bound.forward by a primal active-set method (Nocedal and Wright, Numerical Optimization, 2006,
/// section 16.5): B is positive definite, so it ends.
class BoxQuadraticProgram {
 public:
  BoxQuadraticProgram(const MatrixX& B, const VectorX& p, const FrictionLimits& bound)
      : B_(B), p_(p), bound_(bound), at_(static_cast<std::size_t>(p.size()), free_), z_(VectorX::Zero(p.size())) {
    for (Eigen::Index i = 0; i < p.size(); ++i)
      if (bound.forward[i] <= 0 && bound.backward[i] <= 0) at(i) = pinned_;
  }

  const VectorX& solve() {
    const long most = 100 * (p_.size() + 1);
    for (long turn = 0; turn < most; ++turn) {
      if (step_towards(free_minimum())) continue;
      if (!release_bound()) break;
    }
    return z_;
  }

 private:
  enum BoundStatus { free_, low_, high_, pinned_ };
  BoundStatus& at(Eigen::Index i) { return at_[static_cast<std::size_t>(i)]; }
  /// The one that a goal lies beyond, with its sign.
  double bound_towards(Eigen::Index i, double goal) const { return goal > 0 ? bound_.forward[i] : -bound_.backward[i]; }

  VectorX free_minimum() {
    std::vector<Eigen::Index> inside;
    for (Eigen::Index i = 0; i < p_.size(); ++i)
      if (at(i) == free_) inside.push_back(i);
    VectorX goal = z_;
    if (inside.empty()) return goal;
    const auto count = static_cast<Eigen::Index>(inside.size());
    MatrixX matrix(count, count);
    VectorX right(count);
    for (Eigen::Index a = 0; a < count; ++a) {
      const Eigen::Index i = inside[static_cast<std::size_t>(a)];
      right[a] = p_[i];
      for (Eigen::Index j = 0; j < p_.size(); ++j)
        if (at(j) != free_) right[a] -= B_(i, j) * z_[j];
      for (Eigen::Index b = 0; b < count; ++b) matrix(a, b) = B_(i, inside[static_cast<std::size_t>(b)]);
    }
    const VectorX solution = Eigen::LDLT<MatrixX>(matrix).solve(right);
    for (Eigen::Index a = 0; a < count; ++a) goal[inside[static_cast<std::size_t>(a)]] = solution[a];
    return goal;
  }

  /// Towards the goal as far as the bounds let. @return true if one stopped it
  bool step_towards(const VectorX& goal) {
    double part = 1;
    Eigen::Index first = -1;
    for (Eigen::Index i = 0; i < p_.size(); ++i) {
      if (at(i) != free_ || std::abs(goal[i]) <= std::abs(bound_towards(i, goal[i]))) continue;
      const double reach = std::clamp((bound_towards(i, goal[i]) - z_[i]) / (goal[i] - z_[i]), 0.0, 1.0);
      if (first >= 0 && reach >= part) continue;
      part = reach;
      first = i;
    }
    z_ += part * (goal - z_);
    if (first < 0) return false;
    at(first) = goal[first] > 0 ? high_ : low_;
    z_[first] = bound_towards(first, goal[first]);
    return true;
  }

  bool release_bound() {
    const VectorX pull = p_ - B_ * z_;
    Eigen::Index worst = -1;
    double most = 0;
    for (Eigen::Index i = 0; i < p_.size(); ++i) {
      const double inwards = at(i) == high_ ? -pull[i] : at(i) == low_ ? pull[i] : 0;
      const double size = std::abs(p_[i]) + B_.row(i).cwiseAbs().dot(z_.cwiseAbs());
      if (inwards <= 1e-15 * size || inwards <= most) continue;
      most = inwards;
      worst = i;
    }
    if (worst < 0) return false;
    at(worst) = free_;
    return true;
  }

  const MatrixX& B_;
  const VectorX& p_;
  const FrictionLimits& bound_;
  std::vector<BoundStatus> at_;
  VectorX z_;
};

/// One question with fixed limits, in forces that count as parts of what each joint holds at rest.
struct StickIterate {
  VectorX friction, acceleration, size;
};

VectorX max_friction_limit(const FrictionLimits& limits) { return limits.forward.cwiseMax(limits.backward); }

StickIterate solve_with_limits(const StickProblem& problem, const FrictionLimits& limit) {
  const Eigen::Index m = problem.free_acceleration.size();
  const VectorX unit = max_friction_limit(problem.static_limit);
  MatrixX B = unit.asDiagonal() * problem.response * unit.asDiagonal();
  const VectorX p = unit.cwiseProduct(problem.free_acceleration);
  FrictionLimits bound{limit.forward.cwiseQuotient(unit), limit.backward.cwiseQuotient(unit)};
  const double largest = std::max(max_coefficient(B.diagonal()), 0.0);
  for (Eigen::Index i = 0; i < m; ++i) {
    if (B(i, i) > response_epsilon * largest) {
      B(i, i) *= 1 + least_norm_weight;
    } else {
      bound.forward[i] = bound.backward[i] = 0;
      B(i, i) += 1;
    }
  }
  StickIterate reply;
  reply.friction = unit.cwiseProduct(BoxQuadraticProgram(B, p, bound).solve());
  reply.acceleration = problem.free_acceleration - problem.response * reply.friction;
  reply.size = problem.free_acceleration.cwiseAbs() + problem.response.cwiseAbs() * reply.friction.cwiseAbs();
  return reply;
}

/// Of the larger limit, of the joint that has least left.
double min_friction_reserve(const StickProblem& problem, const VectorX& friction) {
  const FrictionLimits& limit = problem.static_limit;
  const VectorX left = (limit.forward - friction).cwiseMin(limit.backward + friction);
  return min_coefficient(left.cwiseQuotient(max_friction_limit(limit)));
}

}  // namespace

StickSolution solve_stick_slip(const StickProblem& problem) {
  const Eigen::Index m = problem.free_acceleration.size();
  StickSolution answer;
  answer.slip_direction.assign(static_cast<std::size_t>(m), 0);
  answer.friction = VectorX::Zero(m);
  if (m == 0) return answer;
  FrictionLimits limit = problem.static_limit;
  for (Eigen::Index turn = 0; turn <= m; ++turn) {
    const StickIterate reply = solve_with_limits(problem, limit);
    bool lower = false;
    double beyond = 0;
    for (Eigen::Index i = 0; i < m; ++i) {
      const double w = reply.acceleration[i];
      const bool moves = std::abs(w) > relative_acceleration_tolerance * reply.size[i] &&
                         std::abs(w) > problem.acceleration_tolerance[i];
      answer.slip_direction[static_cast<std::size_t>(i)] = !moves ? 0 : w > 0 ? 1 : -1;
      if (!moves) continue;
      beyond = std::max(beyond, std::abs(w) / reply.size[i]);
      for (VectorX FrictionLimits::*way : {&FrictionLimits::forward, &FrictionLimits::backward}) {
        lower = lower || (limit.*way)[i] > (problem.sliding_limit.*way)[i];
        (limit.*way)[i] = (problem.sliding_limit.*way)[i];
      }
    }
    if (turn == 0)
      answer.margin = beyond > 0 ? -beyond : std::max(min_friction_reserve(problem, reply.friction), least_norm_weight);
    answer.friction = reply.friction;
    if (!lower) break;
  }
  return answer;
}

}  // namespace balance
