#include "balance/mechanics/dynamics/stiction.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/loop_dynamics.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

// Friction in the joints: smoothed where a controller computes with it, with true rest where the mechanism itself moves.

namespace {

constexpr double rest_acceleration_epsilon = 1e-13;  // part of the largest acceleration below which one is round-off
constexpr double rest_rate_round_off_fraction =
    1e-3;  // part of what counts as rest that round-off makes of a rate of zero

/// sign(v), smooth over |v| < width.
double smooth_sign(double speed, double width) {
  const double x = speed / width;
  return x >= 1 ? 1 : x <= -1 ? -1 : x * (3 - x * x) / 2;
}

}  // namespace

/// What a joint that moves resists with.
template <class S>
double LoopDynamics<S>::friction_force(const JointFriction& joint, double rate) const {
  if (joint.regularisation_speed > 0)
    return joint.law.viscous * rate +
           joint.law.dry_friction(rate < 0 ? -1 : 1) * smooth_sign(rate, joint.regularisation_speed);
  return sliding_friction(joint.law, rate, joint.slip_direction);
}

template <class S>
void LoopDynamics<S>::add_friction(const double* dy) {
  for (const JointFriction& joint : frictions_)
    joint.coordinate.add_generalised_force(friction_force(joint, joint.rate(dy)), tau_.data());
}

template <class S>
double LoopDynamics<S>::friction_power(const double* dy) const {
  double sum = 0;
  for (const JointFriction& joint : frictions_) sum += joint.rate(dy) * friction_force(joint, joint.rate(dy));
  return sum;
}

template <class S>
void LoopDynamics<S>::reset_friction() {
  sticking_.clear();
  for (JointFriction& joint : frictions_) joint.is_sticking = false, joint.slip_direction = 0, joint.rate_tolerance = 0;
}

template <class S>
std::vector<bool> LoopDynamics<S>::sticking_columns() const {
  std::vector<bool> out(static_cast<std::size_t>(columns()), false);
  for (const int r : sticking_) out[frictions_[r].column()] = true;
  return out;
}

template <class S>
void LoopDynamics<S>::mark_sticking_columns() {
  const std::vector<bool> stuck = sticking_columns();
  is_sticking_column_.clear();
  for (const int column : columns_) is_sticking_column_.push_back(stuck[column]);
  held_count_ = static_cast<std::size_t>(std::count(is_sticking_column_.begin(), is_sticking_column_.end(), true));
}

/// Leaves zero accelerations to the independent columns that joints hold.
template <class S>
void LoopDynamics<S>::fix_sticking_accelerations() {
  const int d = freedoms_;
  for (int a = 0; a < d; ++a) {
    if (is_sticking_column_[a]) right_[a] = 0;
    for (int b = 0; b <= a; ++b)
      if (is_sticking_column_[a] || is_sticking_column_[b]) factor_[a * d + b] = a == b ? 1 : 0;
  }
}

/// How the joints `at_rest` answer to forces, in the acceleration's terms (docs/theory.md, section 8).
template <class S>
StickProblem LoopDynamics<S>::stick_problem(const double* efforts, const std::vector<int>& at_rest) {
  const int d = freedoms_;
  const auto m = static_cast<Eigen::Index>(at_rest.size());
  VectorX right = -bias_;
  for (const ActuatedColumn& driven : driven_)
    for (int k = 0; k < d; ++k) right[k] += C_[driven.column * d + k] * driven.ratio * efforts[driven.actuator];
  const Eigen::LLT<MatrixX> mass(M_);
  const VectorX free = mass.solve(right);
  double largest = 0;
  for (int c = 0; c < columns(); ++c) {
    double size = std::abs(ddy0_[c]);
    for (int k = 0; k < d; ++k) size += std::abs(C_[c * d + k] * free[k]);
    largest = std::max(largest, size / scale_[c]);
  }
  MatrixX G(m, d);
  StickProblem out{{}, VectorX(m), VectorX(m), {VectorX(m), VectorX(m)}, {VectorX(m), VectorX(m)}};
  for (Eigen::Index i = 0; i < m; ++i) {
    const JointFriction& joint = frictions_[at_rest[static_cast<std::size_t>(i)]];
    for (int k = 0; k < d; ++k) G(i, k) = joint.ratio() * C_[joint.column() * d + k];
    out.free_acceleration[i] = G.row(i).dot(free) + joint.ratio() * ddy0_[joint.column()];
    out.acceleration_tolerance[i] = rest_acceleration_epsilon * largest * joint.unit;
    out.static_limit.forward[i] = joint.law.static_limit(1);
    out.static_limit.backward[i] = joint.law.static_limit(-1);
    out.sliding_limit.forward[i] = joint.law.dry_friction(1);
    out.sliding_limit.backward[i] = joint.law.dry_friction(-1);
  }
  out.response = G * mass.solve(G.transpose());
  return out;
}

template <class S>
StickSolution LoopDynamics<S>::solve_stiction_at(double time, const double* dy, const double* efforts,
                                                 const std::vector<int>& at_rest) {
  compute_tree_terms(time, dy);
  reduce_to_independent();
  return solve_stick_slip(stick_problem(efforts, at_rest));
}

template <class S>
FrictionChange LoopDynamics<S>::decide_friction(double time, double* dy, const double* efforts, double rest) {
  at_rest_.clear(), new_stuck_.clear();
  bool turned = false;
  for (std::size_t r = 0; r < frictions_.size(); ++r) {
    JointFriction& joint = frictions_[r];
    joint.last_sign = joint.slip_direction;
    const double rate = joint.rate(dy) / joint.unit;
    const bool stands = joint.has_dry_friction() && (std::abs(rate) <= rest || joint.slip_direction * rate < 0);
    joint.rate_tolerance = rest_rate_round_off_fraction * rest;
    joint.slip_direction = stands || rate == 0 ? 0 : rate > 0 ? 1 : -1;
    if (!stands) continue;
    joint.rate_tolerance = std::max(joint.rate_tolerance, 2 * std::abs(rate));
    at_rest_.push_back(static_cast<int>(r));
  }
  if (!at_rest_.empty()) {
    const StickSolution answer = solve_stiction_at(time, dy, efforts, at_rest_);
    for (std::size_t i = 0; i < at_rest_.size(); ++i) {
      JointFriction& joint = frictions_[at_rest_[i]];
      joint.slip_direction = answer.slip_direction[i];
      joint.friction = answer.friction[static_cast<Eigen::Index>(i)];
      if (joint.slip_direction == 0) new_stuck_.push_back(at_rest_[i]);
    }
  }
  const bool same = new_stuck_ == sticking_;
  sticking_ = new_stuck_;
  for (JointFriction& joint : frictions_) {
    joint.is_sticking = false;
    turned = turned || joint.slip_direction != joint.last_sign;
  }
  for (const int r : sticking_) frictions_[r].is_sticking = true;
  for (const int r : sticking_) dy[frictions_[r].column()] = 0;
  return !same ? FrictionChange::sticking_set : turned ? FrictionChange::slip_direction : FrictionChange::none;
}

template <class S>
double LoopDynamics<S>::friction_margin(double time, const double* dy, const double* efforts, double fastest) {
  double margin = 1;
  const double unit = fastest > 0 ? fastest : 1;
  for (const JointFriction& joint : frictions_) {
    if (!joint.has_dry_friction()) continue;
    const double rate = joint.rate(dy) / joint.unit;
    if (joint.is_sticking)  // a joint that others cannot keep at rest
      margin = std::min(margin, rate == 0 ? 1 : 1e-9 - std::abs(rate) / unit);
    else
      margin = std::min(margin, (joint.slip_direction * rate + joint.rate_tolerance) / unit);
  }
  if (sticking_.empty() || margin < 0) return margin;
  return std::min(margin, solve_stiction_at(time, dy, efforts, sticking_).margin);
}

/// M ν̇ + bias + Gᵀ λ = input · u in the independent columns that are held: λ as decided, corrected where joints share.
template <class S>
void LoopDynamics<S>::add_sticking_friction(const double* efforts, const double* ddy) {
  if (sticking_.empty()) return;
  const int n = columns(), d = freedoms_;
  std::vector<int> held;
  for (int k = 0; k < d; ++k)
    if (is_sticking_column_[k]) held.push_back(k);
  const auto m = static_cast<Eigen::Index>(sticking_.size()), h = static_cast<Eigen::Index>(held.size());
  VectorX lacking = VectorX::Zero(n), needed(h), friction(m);
  for (int i = 0; i < n; ++i) {
    lacking[i] = -tau_[i];
    for (int j = 0; j < n; ++j) lacking[i] -= mass_[i * n + j] * ddy[j];
  }
  for (const ActuatedColumn& driven : driven_) lacking[driven.column] += driven.ratio * efforts[driven.actuator];
  MatrixX G(h, m);
  for (Eigen::Index i = 0; i < m; ++i) friction[i] = frictions_[sticking_[static_cast<std::size_t>(i)]].friction;
  for (Eigen::Index k = 0; k < h; ++k) {
    const int row = held[static_cast<std::size_t>(k)];
    needed[k] = 0;
    for (int i = 0; i < n; ++i) needed[k] += C_[i * d + row] * lacking[i];
    for (Eigen::Index i = 0; i < m; ++i) {
      const JointFriction& joint = frictions_[sticking_[static_cast<std::size_t>(i)]];
      G(k, i) = joint.ratio() * C_[joint.column() * d + row];
    }
  }
  if (h > 0) friction += CompleteOrthogonalDecomposition(G).solve(needed - G * friction);
  for (Eigen::Index i = 0; i < m; ++i) {
    JointFriction& joint = frictions_[sticking_[static_cast<std::size_t>(i)]];
    joint.friction = friction[i];
    joint.coordinate.add_generalised_force(friction[i], tau_.data());
  }
}

#define BALANCE_INSTANTIATE(S)                                                                      \
  template double LoopDynamics<S>::friction_force(const JointFriction&, double) const;              \
  template void LoopDynamics<S>::add_friction(const double*);                                       \
  template double LoopDynamics<S>::friction_power(const double*) const;                             \
  template void LoopDynamics<S>::reset_friction();                                                  \
  template std::vector<bool> LoopDynamics<S>::sticking_columns() const;                             \
  template void LoopDynamics<S>::mark_sticking_columns();                                           \
  template void LoopDynamics<S>::fix_sticking_accelerations();                                      \
  template StickSolution LoopDynamics<S>::solve_stiction_at(double, const double*, const double*,   \
                                                            const std::vector<int>&);               \
  template StickProblem LoopDynamics<S>::stick_problem(const double*, const std::vector<int>&);     \
  template FrictionChange LoopDynamics<S>::decide_friction(double, double*, const double*, double); \
  template double LoopDynamics<S>::friction_margin(double, const double*, const double*, double);   \
  template void LoopDynamics<S>::add_sticking_friction(const double*, const double*);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

namespace {

constexpr double least_norm_weight = 1e-12;  // of the least-norm term that chooses among λ that hold equally well
constexpr double relative_acceleration_tolerance = 1e-9;  // part of the terms of w beyond which w is not zero
constexpr double response_epsilon = 1e-24;  // response, against the largest, of a joint that forces do not move

/// Minimum of ½ zᵀB z − pᵀz within −bound.backward ≤ z ≤ bound.forward by a primal active-set method (Nocedal and Wright, Numerical
/// Optimization, 2006, section 16.5): B is positive definite, so it ends.
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
