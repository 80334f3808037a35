/// Friction in the joints: smoothed where a controller computes with it, with true rest where the mechanism itself moves.

#include "balance/base/factorizations.hpp"
#include "balance/control/loop_dynamics.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double still = 1e-13;  // part of the largest acceleration below which one is round-off
constexpr double noise = 1e-3;   // part of what counts as rest that round-off makes of a rate of zero

/// sign(v), smooth over |v| < width.
double smooth_sign(double speed, double width) {
  const double x = speed / width;
  return x >= 1 ? 1 : x <= -1 ? -1 : x * (3 - x * x) / 2;
}

}  // namespace

/// What a joint that moves resists with.
template <class S>
double LoopDynamics<S>::sliding_part(const JointFriction& joint, double rate) const {
  if (joint.width > 0)
    return joint.law.viscous * rate + joint.law.dry(rate < 0 ? -1 : 1) * smooth_sign(rate, joint.width);
  return sliding_friction(joint.law, rate, joint.sign);
}

template <class S>
void LoopDynamics<S>::add_friction(const double* dy) {
  for (const JointFriction& joint : frictions_) joint.coordinate.load(sliding_part(joint, joint.rate(dy)), tau_.data());
}

template <class S>
double LoopDynamics<S>::friction_power(const double* dy) const {
  double sum = 0;
  for (const JointFriction& joint : frictions_) sum += joint.rate(dy) * sliding_part(joint, joint.rate(dy));
  return sum;
}

template <class S>
void LoopDynamics<S>::forget_friction() {
  stuck_.clear();
  for (JointFriction& joint : frictions_) joint.stuck = false, joint.sign = 0, joint.slack = 0;
}

template <class S>
std::vector<bool> LoopDynamics<S>::stuck_columns() const {
  std::vector<bool> out(static_cast<std::size_t>(columns()), false);
  for (const int r : stuck_) out[frictions_[r].column()] = true;
  return out;
}

template <class S>
void LoopDynamics<S>::hold_columns() {
  const std::vector<bool> stuck = stuck_columns();
  held_.clear();
  for (const int column : columns_) held_.push_back(stuck[column]);
  held_count_ = static_cast<std::size_t>(std::count(held_.begin(), held_.end(), true));
}

/// Leaves zero accelerations to the independent columns that joints hold.
template <class S>
void LoopDynamics<S>::hold() {
  const int d = freedoms_;
  for (int a = 0; a < d; ++a) {
    if (held_[a]) right_[a] = 0;
    for (int b = 0; b <= a; ++b)
      if (held_[a] || held_[b]) factor_[a * d + b] = a == b ? 1 : 0;
  }
}

/// How the joints `at_rest` answer to forces, in the acceleration's terms (docs/theory.md, section 8).
template <class S>
StickProblem LoopDynamics<S>::stick_problem(const double* efforts, const std::vector<int>& at_rest) {
  const int d = freedoms_;
  const auto m = static_cast<Eigen::Index>(at_rest.size());
  VectorX right = -bias_;
  for (const Driven& driven : driven_)
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
    out.free[i] = G.row(i).dot(free) + joint.ratio() * ddy0_[joint.column()];
    out.round_off[i] = still * largest * joint.unit;
    out.at_rest.forward[i] = joint.law.static_limit(1);
    out.at_rest.backward[i] = joint.law.static_limit(-1);
    out.sliding.forward[i] = joint.law.dry(1);
    out.sliding.backward[i] = joint.law.dry(-1);
  }
  out.response = G * mass.solve(G.transpose());
  return out;
}

template <class S>
StickAnswer LoopDynamics<S>::ask_those_at_rest(double time, const double* dy, const double* efforts,
                                               const std::vector<int>& at_rest) {
  prepare(time, dy);
  transform();
  return decide(stick_problem(efforts, at_rest));
}

template <class S>
FrictionChange LoopDynamics<S>::decide_friction(double time, double* dy, const double* efforts, double rest) {
  at_rest_.clear(), new_stuck_.clear();
  bool turned = false;
  for (std::size_t r = 0; r < frictions_.size(); ++r) {
    JointFriction& joint = frictions_[r];
    joint.last_sign = joint.sign;
    const double rate = joint.rate(dy) / joint.unit;
    const bool stands = joint.dry() && (std::abs(rate) <= rest || joint.sign * rate < 0);
    joint.slack = noise * rest;
    joint.sign = stands || rate == 0 ? 0 : rate > 0 ? 1 : -1;
    if (!stands) continue;
    joint.slack = std::max(joint.slack, 2 * std::abs(rate));
    at_rest_.push_back(static_cast<int>(r));
  }
  if (!at_rest_.empty()) {
    const StickAnswer answer = ask_those_at_rest(time, dy, efforts, at_rest_);
    for (std::size_t i = 0; i < at_rest_.size(); ++i) {
      JointFriction& joint = frictions_[at_rest_[i]];
      joint.sign = answer.slips[i];
      joint.friction = answer.friction[static_cast<Eigen::Index>(i)];
      if (joint.sign == 0) new_stuck_.push_back(at_rest_[i]);
    }
  }
  const bool same = new_stuck_ == stuck_;
  stuck_ = new_stuck_;
  for (JointFriction& joint : frictions_) {
    joint.stuck = false;
    turned = turned || joint.sign != joint.last_sign;
  }
  for (const int r : stuck_) frictions_[r].stuck = true;
  for (const int r : stuck_) dy[frictions_[r].column()] = 0;
  return !same ? FrictionChange::sticks : turned ? FrictionChange::slips : FrictionChange::none;
}

template <class S>
double LoopDynamics<S>::friction_margin(double time, const double* dy, const double* efforts, double fastest) {
  double margin = 1;
  const double unit = fastest > 0 ? fastest : 1;
  for (const JointFriction& joint : frictions_) {
    if (!joint.dry()) continue;
    const double rate = joint.rate(dy) / joint.unit;
    if (joint.stuck)  // a joint that others cannot keep at rest
      margin = std::min(margin, rate == 0 ? 1 : 1e-9 - std::abs(rate) / unit);
    else
      margin = std::min(margin, (joint.sign * rate + joint.slack) / unit);
  }
  if (stuck_.empty() || margin < 0) return margin;
  return std::min(margin, ask_those_at_rest(time, dy, efforts, stuck_).margin);
}

/// M ν̇ + bias + Gᵀ λ = input · u in the independent columns that are held: λ as decided, corrected where joints share.
template <class S>
void LoopDynamics<S>::add_stuck_friction(const double* efforts, const double* ddy) {
  if (stuck_.empty()) return;
  const int n = columns(), d = freedoms_;
  std::vector<int> held;
  for (int k = 0; k < d; ++k)
    if (held_[k]) held.push_back(k);
  const auto m = static_cast<Eigen::Index>(stuck_.size()), h = static_cast<Eigen::Index>(held.size());
  VectorX lacking = VectorX::Zero(n), needed(h), friction(m);
  for (int i = 0; i < n; ++i) {
    lacking[i] = -tau_[i];
    for (int j = 0; j < n; ++j) lacking[i] -= mass_[i * n + j] * ddy[j];
  }
  for (const Driven& driven : driven_) lacking[driven.column] += driven.ratio * efforts[driven.actuator];
  MatrixX G(h, m);
  for (Eigen::Index i = 0; i < m; ++i) friction[i] = frictions_[stuck_[static_cast<std::size_t>(i)]].friction;
  for (Eigen::Index k = 0; k < h; ++k) {
    const int row = held[static_cast<std::size_t>(k)];
    needed[k] = 0;
    for (int i = 0; i < n; ++i) needed[k] += C_[i * d + row] * lacking[i];
    for (Eigen::Index i = 0; i < m; ++i) {
      const JointFriction& joint = frictions_[stuck_[static_cast<std::size_t>(i)]];
      G(k, i) = joint.ratio() * C_[joint.column() * d + row];
    }
  }
  if (h > 0) friction += CompleteOrthogonalDecomposition(G).solve(needed - G * friction);
  for (Eigen::Index i = 0; i < m; ++i) {
    JointFriction& joint = frictions_[stuck_[static_cast<std::size_t>(i)]];
    joint.friction = friction[i];
    joint.coordinate.load(friction[i], tau_.data());
  }
}

#define BALANCE_INSTANTIATE(S)                                                                      \
  template double LoopDynamics<S>::sliding_part(const JointFriction&, double) const;                \
  template void LoopDynamics<S>::add_friction(const double*);                                       \
  template double LoopDynamics<S>::friction_power(const double*) const;                             \
  template void LoopDynamics<S>::forget_friction();                                                 \
  template std::vector<bool> LoopDynamics<S>::stuck_columns() const;                                \
  template void LoopDynamics<S>::hold_columns();                                                    \
  template void LoopDynamics<S>::hold();                                                            \
  template StickAnswer LoopDynamics<S>::ask_those_at_rest(double, const double*, const double*,     \
                                                          const std::vector<int>&);                 \
  template StickProblem LoopDynamics<S>::stick_problem(const double*, const std::vector<int>&);     \
  template FrictionChange LoopDynamics<S>::decide_friction(double, double*, const double*, double); \
  template double LoopDynamics<S>::friction_margin(double, const double*, const double*, double);   \
  template void LoopDynamics<S>::add_stuck_friction(const double*, const double*);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
