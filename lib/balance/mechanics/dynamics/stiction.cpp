#include "balance/mechanics/dynamics/stiction.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/loop_dynamics.hpp"

#include <algorithm>
#include <cmath>

namespace balance::dynamics {

// Joint friction: smoothed in the models of controllers, with true rest for the mechanism itself.

namespace {

constexpr double rest_acceleration_epsilon = 1e-13;    // fraction of the largest acceleration that is round-off
constexpr double rest_rate_round_off_fraction = 1e-3;  // round-off of a zero rate, as a fraction of the rest threshold

/// sign(v), smooth over |v| < width.
double smooth_sign(double speed, double width) {
  const double x = speed / width;
  return x >= 1 ? 1 : x <= -1 ? -1 : x * (3 - x * x) / 2;
}

}  // namespace

/// Friction force of a moving joint.
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
  double sum = external_.has_dampers() ? external_.damper_power(state_) : 0;
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

/// Sets the accelerations of independent columns that are held by joints to zero.
template <class S>
void LoopDynamics<S>::fix_sticking_accelerations() {
  const int d = freedoms_;
  for (int a = 0; a < d; ++a) {
    if (is_sticking_column_[a]) rhs_[a] = 0;
    for (int b = 0; b <= a; ++b)
      if (is_sticking_column_[a] || is_sticking_column_[b]) factor_[a * d + b] = a == b ? 1 : 0;
  }
}

/// Response of the joints `at_rest` to forces, in terms of their accelerations (docs/theory.md, section 8).
template <class S>
StickProblem LoopDynamics<S>::stick_problem(const double* efforts, const std::vector<int>& at_rest) {
  const int d = freedoms_;
  const auto m = static_cast<Eigen::Index>(at_rest.size());
  VectorX rhs = -bias_;
  for (const ActuatedColumn& actuated : actuated_columns_)
    for (int k = 0; k < d; ++k) rhs[k] += C_[actuated.column * d + k] * actuated.ratio * efforts[actuated.actuator];
  const Eigen::LLT<MatrixX> mass(M_);
  const VectorX free_accelerations = mass.solve(rhs);
  double max_acceleration = 0;
  for (int c = 0; c < columns(); ++c) {
    double magnitude = std::abs(ddy0_[c]);
    for (int k = 0; k < d; ++k) magnitude += std::abs(C_[c * d + k] * free_accelerations[k]);
    max_acceleration = std::max(max_acceleration, magnitude / scale_[c]);
  }
  MatrixX G(m, d);
  StickProblem out{{}, VectorX(m), VectorX(m), {VectorX(m), VectorX(m)}, {VectorX(m), VectorX(m)}};
  for (Eigen::Index i = 0; i < m; ++i) {
    const JointFriction& joint = frictions_[at_rest[static_cast<std::size_t>(i)]];
    for (int k = 0; k < d; ++k) G(i, k) = joint.ratio() * C_[joint.column() * d + k];
    out.free_acceleration[i] = G.row(i).dot(free_accelerations) + joint.ratio() * ddy0_[joint.column()];
    out.acceleration_tolerance[i] = rest_acceleration_epsilon * max_acceleration * joint.unit;
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
FrictionChange LoopDynamics<S>::decide_friction(double time, double* dy, const double* efforts, double rest_threshold) {
  at_rest_.clear(), new_stuck_.clear();
  bool has_new_direction = false;
  for (std::size_t r = 0; r < frictions_.size(); ++r) {
    JointFriction& joint = frictions_[r];
    joint.last_sign = joint.slip_direction;
    const double rate = joint.rate(dy) / joint.unit;
    const bool is_at_rest =
        joint.has_dry_friction() && (std::abs(rate) <= rest_threshold || joint.slip_direction * rate < 0);
    joint.rate_tolerance = rest_rate_round_off_fraction * rest_threshold;
    joint.slip_direction = is_at_rest || rate == 0 ? 0 : rate > 0 ? 1 : -1;
    if (!is_at_rest) continue;
    joint.rate_tolerance = std::max(joint.rate_tolerance, 2 * std::abs(rate));
    at_rest_.push_back(static_cast<int>(r));
  }
  if (!at_rest_.empty()) {
    const StickSolution solution = solve_stiction_at(time, dy, efforts, at_rest_);
    for (std::size_t i = 0; i < at_rest_.size(); ++i) {
      JointFriction& joint = frictions_[at_rest_[i]];
      joint.slip_direction = solution.slip_direction[i];
      joint.friction = solution.friction[static_cast<Eigen::Index>(i)];
      if (joint.slip_direction == 0) new_stuck_.push_back(at_rest_[i]);
    }
  }
  const bool is_same_set = new_stuck_ == sticking_;
  sticking_ = new_stuck_;
  for (JointFriction& joint : frictions_) {
    joint.is_sticking = false;
    has_new_direction = has_new_direction || joint.slip_direction != joint.last_sign;
  }
  for (const int r : sticking_) frictions_[r].is_sticking = true;
  for (const int r : sticking_) dy[frictions_[r].column()] = 0;
  return !is_same_set        ? FrictionChange::sticking_set
         : has_new_direction ? FrictionChange::slip_direction
                             : FrictionChange::none;
}

template <class S>
double LoopDynamics<S>::friction_margin(double time, const double* dy, const double* efforts, double reference_rate) {
  double margin = 1;
  const double unit = reference_rate > 0 ? reference_rate : 1;
  for (const JointFriction& joint : frictions_) {
    if (!joint.has_dry_friction()) continue;
    const double rate = joint.rate(dy) / joint.unit;
    if (joint.is_sticking)  // it moves only if its column is dependent and the others cannot keep it at rest
      margin = std::min(margin, rate == 0 ? 1 : 1e-9 - std::abs(rate) / unit);
    else
      margin = std::min(margin, (joint.slip_direction * rate + joint.rate_tolerance) / unit);
  }
  if (sticking_.empty() || margin < 0) return margin;
  return std::min(margin, solve_stiction_at(time, dy, efforts, sticking_).margin);
}

/// Solves M ν̇ + bias + Gᵀ λ = input · u in the independent columns that are held. λ is that of the last decision, with
/// a minimum-norm correction where joints share it.
template <class S>
void LoopDynamics<S>::add_sticking_friction(const double* efforts, const double* ddy) {
  if (sticking_.empty()) return;
  const int n = columns(), d = freedoms_;
  std::vector<int> held_columns;
  for (int k = 0; k < d; ++k)
    if (is_sticking_column_[k]) held_columns.push_back(k);
  const auto m = static_cast<Eigen::Index>(sticking_.size()), h = static_cast<Eigen::Index>(held_columns.size());
  VectorX force_residual = VectorX::Zero(n), required_force(h), friction(m);
  for (int i = 0; i < n; ++i) {
    force_residual[i] = -tau_[i];
    for (int j = 0; j < n; ++j) force_residual[i] -= mass_[i * n + j] * ddy[j];
  }
  for (const ActuatedColumn& actuated : actuated_columns_)
    force_residual[actuated.column] += actuated.ratio * efforts[actuated.actuator];
  MatrixX G(h, m);
  for (Eigen::Index i = 0; i < m; ++i) friction[i] = frictions_[sticking_[static_cast<std::size_t>(i)]].friction;
  for (Eigen::Index k = 0; k < h; ++k) {
    const int row = held_columns[static_cast<std::size_t>(k)];
    required_force[k] = 0;
    for (int i = 0; i < n; ++i) required_force[k] += C_[i * d + row] * force_residual[i];
    for (Eigen::Index i = 0; i < m; ++i) {
      const JointFriction& joint = frictions_[sticking_[static_cast<std::size_t>(i)]];
      G(k, i) = joint.ratio() * C_[joint.column() * d + row];
    }
  }
  if (h > 0) friction += numerics::CompleteOrthogonalDecomposition(G).solve(required_force - G * friction);
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
BALANCE_INSTANTIATE(kinematics::Planar)
BALANCE_INSTANTIATE(kinematics::Spatial)
#undef BALANCE_INSTANTIATE

namespace {

constexpr double least_norm_weight = 1e-12;               // of the minimum-norm term that selects among equivalent λ
constexpr double relative_acceleration_tolerance = 1e-9;  // fraction of the terms of w above which w is not zero
constexpr double response_epsilon = 1e-24;  // response, relative to the largest, of a joint that forces do not move

/// Minimum of ½ zᵀB z − pᵀz within −bound.backward ≤ z ≤ bound.forward by a primal active-set method (Nocedal and
/// Wright, Numerical Optimization, 2006, section 16.5), which terminates because B is positive definite.
class BoxQuadraticProgram {
 public:
  BoxQuadraticProgram(const MatrixX& B, const VectorX& p, const FrictionLimits& bound)
      : B_(B), p_(p), bound_(bound), status_(static_cast<std::size_t>(p.size()), free_), z_(VectorX::Zero(p.size())) {
    for (Eigen::Index i = 0; i < p.size(); ++i)
      if (bound.forward[i] <= 0 && bound.backward[i] <= 0) status(i) = pinned_;
  }

  const VectorX& solve() {
    const long max_iterations = 100 * (p_.size() + 1);
    for (long iteration = 0; iteration < max_iterations; ++iteration) {
      if (step_towards(free_minimum())) continue;
      if (!release_bound()) break;
    }
    return z_;
  }

 private:
  enum BoundStatus { free_, low_, high_, pinned_ };
  BoundStatus& status(Eigen::Index i) { return status_[static_cast<std::size_t>(i)]; }
  /// The bound on the side of a target, with its sign.
  double bound_towards(Eigen::Index i, double target) const {
    return target > 0 ? bound_.forward[i] : -bound_.backward[i];
  }

  VectorX free_minimum() {
    std::vector<Eigen::Index> free_indices;
    for (Eigen::Index i = 0; i < p_.size(); ++i)
      if (status(i) == free_) free_indices.push_back(i);
    VectorX target = z_;
    if (free_indices.empty()) return target;
    const auto count = static_cast<Eigen::Index>(free_indices.size());
    MatrixX matrix(count, count);
    VectorX rhs(count);
    for (Eigen::Index a = 0; a < count; ++a) {
      const Eigen::Index i = free_indices[static_cast<std::size_t>(a)];
      rhs[a] = p_[i];
      for (Eigen::Index j = 0; j < p_.size(); ++j)
        if (status(j) != free_) rhs[a] -= B_(i, j) * z_[j];
      for (Eigen::Index b = 0; b < count; ++b) matrix(a, b) = B_(i, free_indices[static_cast<std::size_t>(b)]);
    }
    const VectorX solution = Eigen::LDLT<MatrixX>(matrix).solve(rhs);
    for (Eigen::Index a = 0; a < count; ++a) target[free_indices[static_cast<std::size_t>(a)]] = solution[a];
    return target;
  }

  /// Moves towards the target as far as the bounds allow. @return true if a bound stopped it
  bool step_towards(const VectorX& target) {
    double step = 1;
    Eigen::Index blocking = -1;
    for (Eigen::Index i = 0; i < p_.size(); ++i) {
      if (status(i) != free_ || std::abs(target[i]) <= std::abs(bound_towards(i, target[i]))) continue;
      const double max_step = std::clamp((bound_towards(i, target[i]) - z_[i]) / (target[i] - z_[i]), 0.0, 1.0);
      if (blocking >= 0 && max_step >= step) continue;
      step = max_step;
      blocking = i;
    }
    z_ += step * (target - z_);
    if (blocking < 0) return false;
    status(blocking) = target[blocking] > 0 ? high_ : low_;
    z_[blocking] = bound_towards(blocking, target[blocking]);
    return true;
  }

  bool release_bound() {
    const VectorX negative_gradient = p_ - B_ * z_;
    Eigen::Index released = -1;
    double max_multiplier = 0;
    for (Eigen::Index i = 0; i < p_.size(); ++i) {
      const double multiplier = status(i) == high_  ? -negative_gradient[i]
                                : status(i) == low_ ? negative_gradient[i]
                                                    : 0;
      const double size = std::abs(p_[i]) + B_.row(i).cwiseAbs().dot(z_.cwiseAbs());
      if (multiplier <= 1e-15 * size || multiplier <= max_multiplier) continue;
      max_multiplier = multiplier;
      released = i;
    }
    if (released < 0) return false;
    status(released) = free_;
    return true;
  }

  const MatrixX& B_;
  const VectorX& p_;
  const FrictionLimits& bound_;
  std::vector<BoundStatus> status_;
  VectorX z_;
};

/// Solution with fixed limits, computed with forces scaled by each joint's static limit.
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
  const double max_response = std::max(numerics::max_coefficient(B.diagonal()), 0.0);
  for (Eigen::Index i = 0; i < m; ++i) {
    if (B(i, i) > response_epsilon * max_response) {
      B(i, i) *= 1 + least_norm_weight;
    } else {
      bound.forward[i] = bound.backward[i] = 0;
      B(i, i) += 1;
    }
  }
  StickIterate iterate;
  iterate.friction = unit.cwiseProduct(BoxQuadraticProgram(B, p, bound).solve());
  iterate.acceleration = problem.free_acceleration - problem.response * iterate.friction;
  iterate.size = problem.free_acceleration.cwiseAbs() + problem.response.cwiseAbs() * iterate.friction.cwiseAbs();
  return iterate;
}

/// Reserve of the joint that has least left, as a fraction of its larger limit.
double min_friction_reserve(const StickProblem& problem, const VectorX& friction) {
  const FrictionLimits& limit = problem.static_limit;
  const VectorX reserve = (limit.forward - friction).cwiseMin(limit.backward + friction);
  return numerics::min_coefficient(reserve.cwiseQuotient(max_friction_limit(limit)));
}

}  // namespace

StickSolution solve_stick_slip(const StickProblem& problem) {
  const Eigen::Index m = problem.free_acceleration.size();
  StickSolution solution;
  solution.slip_direction.assign(static_cast<std::size_t>(m), 0);
  solution.friction = VectorX::Zero(m);
  if (m == 0) return solution;
  FrictionLimits limit = problem.static_limit;
  for (Eigen::Index iteration = 0; iteration <= m; ++iteration) {
    const StickIterate iterate = solve_with_limits(problem, limit);
    bool is_limit_lowered = false;
    double max_excess = 0;
    for (Eigen::Index i = 0; i < m; ++i) {
      const double w = iterate.acceleration[i];
      const bool moves = std::abs(w) > relative_acceleration_tolerance * iterate.size[i] &&
                         std::abs(w) > problem.acceleration_tolerance[i];
      solution.slip_direction[static_cast<std::size_t>(i)] = !moves ? 0 : w > 0 ? 1 : -1;
      if (!moves) continue;
      max_excess = std::max(max_excess, std::abs(w) / iterate.size[i]);
      for (VectorX FrictionLimits::*direction : {&FrictionLimits::forward, &FrictionLimits::backward}) {
        is_limit_lowered = is_limit_lowered || (limit.*direction)[i] > (problem.sliding_limit.*direction)[i];
        (limit.*direction)[i] = (problem.sliding_limit.*direction)[i];
      }
    }
    if (iteration == 0)
      solution.margin =
          max_excess > 0 ? -max_excess : std::max(min_friction_reserve(problem, iterate.friction), least_norm_weight);
    solution.friction = iterate.friction;
    if (!is_limit_lowered) break;
  }
  return solution;
}

}  // namespace balance::dynamics
