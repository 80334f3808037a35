/// Friction in the joints: smoothed where a controller computes with it, with true rest where the mechanism itself moves.

#include "balance/base/factorizations.hpp"
#include "balance/control/loop_dynamics.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

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

}  // namespace balance
