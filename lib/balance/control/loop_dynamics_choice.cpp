/// Which coordinates are independent, and the way there from a guess.

#include "balance/base/factorizations.hpp"
#include "balance/control/column_choice.hpp"
#include "balance/control/loop_dynamics.hpp"
#include "balance/control/tree_state.hpp"
#include "balance/kinematics/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace balance {

namespace {

constexpr double regular = 1e-5;  // smallest relative pivot of closures that have their full rank
constexpr double usable = 1e-5;   // the same that preferred coordinates must leave
// What makes a column a dependent one where there is a choice: being a spherical joint's, whose own coordinates mean little, and taking part in
// one loop only, which lets the loops be solved one by one.
constexpr double spherical_weight = 10;
constexpr double own_loop_weight = 3;

MotionOutcome stopped(MotionStatus status, double time, std::string reason) {
  return {status, time, std::move(reason), {}};
}

}  // namespace

template <class S>
std::vector<int> LoopDynamics<S>::preferred_columns() const {
  std::vector<int> out;
  for (const CoordinateId coordinate : options_.preferred) {
    if (!full_.sources[coordinate].depends_on_one()) return {};
    const int column = full_.sources[coordinate].terms[0].first;
    if (std::find(out.begin(), out.end(), column) != out.end()) return {};
    out.push_back(column);
  }
  if (static_cast<int>(out.size()) != freedoms_) return {};
  return out;
}

template <class S>
void LoopDynamics<S>::weigh_columns() {
  weight_.assign(columns(), own_loop_weight);
  std::vector<int> loops(columns(), 0);
  for (const Closure<S>& closure : full_.closures) {
    std::vector<bool> seen(columns(), false);
    for (const PathStep& step : closure.path) seen[full_.nodes[step.node].column] = true;
    for (int c = 0; c < columns(); ++c)
      if (seen[c] && ++loops[c] > 1) weight_[c] = 1;
  }
  for (const NodeId spherical : full_.spherical_joints)
    for (int k = spherical; k < spherical + 3; ++k)
      if (full_.nodes[k].column >= 0) weight_[full_.nodes[k].column] = spherical_weight;
}

template <class S>
bool LoopDynamics<S>::choose(const double* y, bool prefer) {
  ++choices_;
  const int n = columns(), d = freedoms_, rank = n - d;
  std::vector<int> wanted;
  if (prefer) wanted = preferred_columns();
  std::vector<int> rows(full_.closure_rows);
  std::iota(rows.begin(), rows.end(), 0);
  if (open_tree()) {
    columns_ = static_cast<int>(wanted.size()) == n ? wanted : others({}, n);
  } else {
    // one row of a point's closure lies along the joint's axes, both together may lie along the world's
    Tree<S> by_axes = full_;
    for (Closure<S>& closure : by_axes.closures) closure.pinned = closure.pinned && !redundant();
    System<S> closures(by_axes, Drive<S>{});
    MatrixX jacobian;
    closures.rates(Eigen::Map<const VectorX>(y, n), {}, jacobian);
    MatrixX weighted = jacobian;
    for (int c = 0; c < n; ++c) weighted.col(c) *= weight_[c];
    double last;
    std::vector<int> dependent = pivots(weighted, rank, closure_regularity_);
    if (closure_regularity_ < regular) return false;
    if (any_stuck()) dependent = pivots_that_move(weighted, rank, stuck_columns());
    if (!wanted.empty() && smallest_to_largest(picked(jacobian, others(wanted, n))) > usable)
      dependent = others(wanted, n);
    else
      wanted = others(dependent, n);
    columns_ = wanted;
    if (redundant()) rows = pivots(picked(jacobian, dependent).transpose(), rank, last);
  }
  take_rows(rows);
  depends_.clear();
  for (const Node<S>& node : full_.nodes)
    depends_.push_back(std::find(columns_.begin(), columns_.end(), node.column) == columns_.end());
  drive_ = {};
  for (const int column : columns_)
    drive_.linear.push_back({{{column, 1.0}}, 0, full_.column_kind_length[column] != 0});
  sample_.value.setZero(d);
  sample_.rate.setZero(d);
  sample_.acceleration.setZero(d);
  hold_columns();
  C_.assign(n * d, 0), HC_.assign(n * d, 0);
  M_.setZero(d, d), bias_.setZero(d);
  factor_.assign(d * d, 0), right_.assign(d, 0);
  if (open_tree()) return true;
  equations_.emplace(tree_, drive_, false);
  if (equations_->structurally_singular()) return false;
  VectorX here = Eigen::Map<const VectorX>(y, n);
  for (int k = 0; k < d; ++k) sample_.value[k] = here[columns_[k]];
  poses(tree_, here.data(), state_);
  equations_->fill(state_, here.data(), sample_, x_.data());
  const bool good = equations_->factorise();
  regularity_at_choice_ = equations_->regularity();
  return good;
}

/// Leaves these rows of the closures in the tree that the equations are made of.
template <class S>
void LoopDynamics<S>::take_rows(const std::vector<int>& rows) {
  tree_.closures = full_.closures;
  tree_.closure_rows = static_cast<int>(rows.size());
  tree_.slides = full_.slides;
  if (tree_.closure_rows == full_.closure_rows) return;
  tree_.slides = false;
  int row = 0;
  for (Closure<S>& closure : tree_.closures) {
    std::vector<ClosureRow> kept;
    int along = 0;
    for (const ClosureRow& one : closure.rows) {
      if (!std::binary_search(rows.begin(), rows.end(), row++)) continue;
      kept.push_back(one);
      along += one.kind == ClosureRow::Kind::along;
    }
    closure.rows = kept;
    closure.pinned = along == S::dimension;
    tree_.slides = tree_.slides || !closure.pinned;
  }
}

template <class S>
MotionOutcome LoopDynamics<S>::assemble(const VectorX& q, const VectorX& dq, VectorX& y, VectorX& dy) {
  for (std::size_t b = 0; b < full_.spherical_joints.size(); ++b)
    full_.nodes[full_.spherical_joints[b]].R_PF = tree_.nodes[full_.spherical_joints[b]].R_PF = reference_[b];
  forget_friction();
  to_tree(mechanism_, full_, q, dq, y, dy);
  rereference_spherical_joints(0.5, y.data(), dy.data());
  System<S> closures(full_, Drive<S>{});
  const Solution nearest = solve(closures, y, {});
  if (!nearest.found)
    return stopped(MotionStatus::not_assembled, 0, "the loops do not close near the joint coordinates given");
  if (freedoms_ < 0) freedoms_ = columns() - generic_closure_rank(full_, nearest.y);
  const auto singular = [&] {
    return stopped(
        MotionStatus::constraint_singularity, 0,
        "constraint singularity: the loop closures lose rank, the mechanism gains a freedom; configuration: " +
            configuration_text(mechanism_, q));
  };
  if (!choose(nearest.y.data(), true)) return singular();
  // the independent ones as given, where the others can follow
  System<S> held(full_, drive_);
  DriveSample target;
  target.value.resize(freedoms_);
  for (int k = 0; k < freedoms_; ++k) target.value[k] = y[columns_[k]];
  const Solution exact = solve(held, nearest.y, target);
  if (!exact.found)
    return stopped(MotionStatus::not_assembled, 0,
                   "the loops do not close with the independent joint coordinates as given");
  y = exact.y;
  rereference_spherical_joints(1, y.data(), dy.data());
  if (!choose(y.data(), true) || !close(y.data(), dy.data())) return singular();
  return {MotionStatus::done, 0, "", {}};
}

template <class S>
double LoopDynamics<S>::mobility() {
  if (open_tree()) return 1;
  return equations_->least_singular_value();
}

/// τ = Sᵀu + Jᵀλ with τ what the tree's motion takes.
template <class S>
void LoopDynamics<S>::multipliers(const double* efforts, const double* ddy, const double* y, std::vector<double>& out) {
  const int n = columns();
  out.assign(full_.closure_rows, 0);
  if (open_tree()) return;
  for (int i = 0; i < n; ++i) {
    x_[i] = tau_[i];
    for (int j = 0; j < n; ++j) x_[i] += mass_[i * n + j] * ddy[j];
  }
  for (const Driven& driven : driven_) x_[driven.column] -= driven.ratio * efforts[driven.actuator];
  if (!redundant()) {
    equations_->solve_transposed(x_.data());
    std::copy_n(x_.data(), full_.closure_rows, out.data());
    return;
  }
  System<S> closures(full_, Drive<S>{});
  VectorX needed(n);
  MatrixX jacobian;
  closures.rates(Eigen::Map<const VectorX>(y, n), {}, jacobian);
  for (int c = 0; c < n; ++c) needed[c] = scale_[c] * x_[c];
  CompleteOrthogonalDecomposition decomposition;
  decomposition.setThreshold(1e-8);
  decomposition.compute(jacobian.transpose());
  const VectorX scaled = decomposition.solve(needed);
  int r = 0;
  for (const Closure<S>& closure : full_.closures)
    for (const ClosureRow& row : closure.rows) {
      out[r] = scaled[r] * row_unit(full_, closure, row);
      ++r;
    }
}

template <class S>
bool LoopDynamics<S>::rereference_spherical_joints(double limit, double* y, double* dy) {
  bool any = false;
  for (const NodeId spherical : full_.spherical_joints) {
    const double middle = std::remainder(y[full_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    const Tree<S> before = full_;
    const VectorX y_before = Eigen::Map<const VectorX>(y, columns());
    rereference(full_, spherical, y);
    tree_.nodes[spherical].R_PF = full_.nodes[spherical].R_PF;
    carry_spherical_rates(before, y_before.data(), full_, y, spherical, dy);
    any = true;
  }
  return any;
}

template <class S>
double LoopDynamics<S>::residual() const {
  double worst = 0;
  for (const Closure<S>& closure : full_.closures) {
    if (closure.of_rates()) break;
    const ClosurePose<S> pose = closure_pose(state_, closure);
    for (const ClosureRow& row : closure.rows)
      worst = std::max(worst, std::abs(row_unit(full_, closure, row) * closure_residual(pose, row)));
  }
  return worst;
}

#define BALANCE_INSTANTIATE(S)                                                                          \
  template bool LoopDynamics<S>::rereference_spherical_joints(double, double*, double*);                \
  template double LoopDynamics<S>::residual() const;                                                    \
  template void LoopDynamics<S>::weigh_columns();                                                       \
  template std::vector<int> LoopDynamics<S>::preferred_columns() const;                                 \
  template bool LoopDynamics<S>::choose(const double*, bool);                                           \
  template void LoopDynamics<S>::take_rows(const std::vector<int>&);                                    \
  template MotionOutcome LoopDynamics<S>::assemble(const VectorX&, const VectorX&, VectorX&, VectorX&); \
  template double LoopDynamics<S>::mobility();                                                          \
  template void LoopDynamics<S>::multipliers(const double*, const double*, const double*, std::vector<double>&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
