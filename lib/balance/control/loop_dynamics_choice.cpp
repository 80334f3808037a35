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

constexpr double closure_rank_tolerance = 1e-5;       // smallest relative pivot of closures that have their full rank
constexpr double preferred_columns_tolerance = 1e-5;  // the same that preferred coordinates must leave
// What makes a column a dependent one where there is a choice: being a spherical joint's, whose own coordinates mean little, and taking part in
// one loop only, which lets the loops be solved one by one.
constexpr double spherical_weight = 10;
constexpr double own_loop_weight = 3;

MotionOutcome make_outcome(MotionStatus status, double time, std::string reason) {
  return {status, time, std::move(reason), {}};
}

}  // namespace

template <class S>
std::vector<int> LoopDynamics<S>::preferred_columns() const {
  std::vector<int> out;
  for (const CoordinateId coordinate : options_.preferred) {
    if (!full_tree_.coordinate_expressions[coordinate].has_single_term()) return {};
    const int column = full_tree_.coordinate_expressions[coordinate].terms[0].first;
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
  for (const Closure<S>& closure : full_tree_.closures) {
    std::vector<bool> seen(columns(), false);
    for (const PathStep& step : closure.path) seen[full_tree_.nodes[step.node].column] = true;
    for (int c = 0; c < columns(); ++c)
      if (seen[c] && ++loops[c] > 1) weight_[c] = 1;
  }
  for (const NodeId spherical : full_tree_.spherical_joints)
    for (int k = spherical; k < spherical + 3; ++k)
      if (full_tree_.nodes[k].column >= 0) weight_[full_tree_.nodes[k].column] = spherical_weight;
}

template <class S>
bool LoopDynamics<S>::choose_independent_columns(const double* y, bool prefer) {
  ++choices_;
  const int n = columns(), d = freedoms_, rank = n - d;
  std::vector<int> wanted;
  if (prefer) wanted = preferred_columns();
  std::vector<int> rows(full_tree_.closure_rows);
  std::iota(rows.begin(), rows.end(), 0);
  if (is_open_tree()) {
    columns_ = static_cast<int>(wanted.size()) == n ? wanted : complement_indices({}, n);
  } else {
    // one row of a point's closure lies along the joint's axes, both together may lie along the world's
    Tree<S> by_axes = full_tree_;
    for (Closure<S>& closure : by_axes.closures)
      closure.has_coincident_origins = closure.has_coincident_origins && !has_redundant_closures();
    ConstraintSystem<S> closures(by_axes, Drive<S>{});
    MatrixX jacobian;
    closures.velocity_jacobian(Eigen::Map<const VectorX>(y, n), {}, jacobian);
    MatrixX weighted = jacobian;
    for (int c = 0; c < n; ++c) weighted.col(c) *= weight_[c];
    double last;
    std::vector<int> dependent = pivot_columns(weighted, rank, closure_regularity_);
    if (closure_regularity_ < closure_rank_tolerance) return false;
    if (is_any_sticking()) dependent = pivot_moving_columns(weighted, rank, sticking_columns());
    if (!wanted.empty() && compute_reciprocal_condition(select_columns(jacobian, complement_indices(wanted, n))) >
                               preferred_columns_tolerance)
      dependent = complement_indices(wanted, n);
    else
      wanted = complement_indices(dependent, n);
    columns_ = wanted;
    if (has_redundant_closures()) rows = pivot_columns(select_columns(jacobian, dependent).transpose(), rank, last);
  }
  select_closure_rows(rows);
  is_dependent_node_.clear();
  for (const Node<S>& node : full_tree_.nodes)
    is_dependent_node_.push_back(std::find(columns_.begin(), columns_.end(), node.column) == columns_.end());
  drive_ = {};
  for (const int column : columns_)
    drive_.linear.push_back({{{column, 1.0}}, 0, full_tree_.is_length_column[column] != 0});
  sample_.value.setZero(d);
  sample_.rate.setZero(d);
  sample_.acceleration.setZero(d);
  mark_sticking_columns();
  C_.assign(n * d, 0), HC_.assign(n * d, 0);
  M_.setZero(d, d), bias_.setZero(d);
  factor_.assign(d * d, 0), right_.assign(d, 0);
  if (is_open_tree()) return true;
  equations_.emplace(tree_, drive_, false);
  if (equations_->structurally_singular()) return false;
  VectorX here = Eigen::Map<const VectorX>(y, n);
  for (int k = 0; k < d; ++k) sample_.value[k] = here[columns_[k]];
  compute_poses(tree_, here.data(), state_);
  equations_->evaluate(state_, here.data(), sample_, x_.data());
  const bool good = equations_->factorise();
  regularity_at_choice_ = equations_->regularity();
  return good;
}

/// Leaves these rows of the closures in the tree that the equations are made of.
template <class S>
void LoopDynamics<S>::select_closure_rows(const std::vector<int>& rows) {
  tree_.closures = full_tree_.closures;
  tree_.closure_rows = static_cast<int>(rows.size());
  tree_.has_sliding_closures = full_tree_.has_sliding_closures;
  if (tree_.closure_rows == full_tree_.closure_rows) return;
  tree_.has_sliding_closures = false;
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
    closure.has_coincident_origins = along == S::dimension;
    tree_.has_sliding_closures = tree_.has_sliding_closures || !closure.has_coincident_origins;
  }
}

template <class S>
MotionOutcome LoopDynamics<S>::assemble(const VectorX& q, const VectorX& dq, VectorX& y, VectorX& dy) {
  for (std::size_t b = 0; b < full_tree_.spherical_joints.size(); ++b)
    full_tree_.nodes[full_tree_.spherical_joints[b]].R_PF = tree_.nodes[full_tree_.spherical_joints[b]].R_PF =
        reference_[b];
  reset_friction();
  to_tree_coordinates(mechanism_, full_tree_, q, dq, y, dy);
  reset_spherical_references(0.5, y.data(), dy.data());
  ConstraintSystem<S> closures(full_tree_, Drive<S>{});
  const AssemblySolution nearest = solve_assembly(closures, y, {});
  if (!nearest.found)
    return make_outcome(MotionStatus::not_assembled, 0, "the loops do not close near the joint coordinates given");
  if (freedoms_ < 0) freedoms_ = columns() - find_generic_closure_rank(full_tree_, nearest.y);
  const auto singular = [&] {
    return make_outcome(
        MotionStatus::constraint_singularity, 0,
        "constraint singularity: the loop closures lose rank, the mechanism gains a freedom; configuration: " +
            format_configuration(mechanism_, q));
  };
  if (!choose_independent_columns(nearest.y.data(), true)) return singular();
  // the independent ones as given, where the others can follow
  ConstraintSystem<S> held(full_tree_, drive_);
  DriveSample target;
  target.value.resize(freedoms_);
  for (int k = 0; k < freedoms_; ++k) target.value[k] = y[columns_[k]];
  const AssemblySolution exact = solve_assembly(held, nearest.y, target);
  if (!exact.found)
    return make_outcome(MotionStatus::not_assembled, 0,
                        "the loops do not close with the independent joint coordinates as given");
  y = exact.y;
  reset_spherical_references(1, y.data(), dy.data());
  if (!choose_independent_columns(y.data(), true) || !solve_dependent(y.data(), dy.data())) return singular();
  return {MotionStatus::done, 0, "", {}};
}

template <class S>
double LoopDynamics<S>::mobility() {
  if (is_open_tree()) return 1;
  return equations_->min_singular_value();
}

/// τ = Sᵀu + Jᵀλ with τ what the tree's motion takes.
template <class S>
void LoopDynamics<S>::multipliers(const double* efforts, const double* ddy, const double* y, std::vector<double>& out) {
  const int n = columns();
  out.assign(full_tree_.closure_rows, 0);
  if (is_open_tree()) return;
  for (int i = 0; i < n; ++i) {
    x_[i] = tau_[i];
    for (int j = 0; j < n; ++j) x_[i] += mass_[i * n + j] * ddy[j];
  }
  for (const ActuatedColumn& driven : driven_) x_[driven.column] -= driven.ratio * efforts[driven.actuator];
  if (!has_redundant_closures()) {
    equations_->solve_transposed(x_.data());
    std::copy_n(x_.data(), full_tree_.closure_rows, out.data());
    return;
  }
  ConstraintSystem<S> closures(full_tree_, Drive<S>{});
  VectorX needed(n);
  MatrixX jacobian;
  closures.velocity_jacobian(Eigen::Map<const VectorX>(y, n), {}, jacobian);
  for (int c = 0; c < n; ++c) needed[c] = scale_[c] * x_[c];
  CompleteOrthogonalDecomposition decomposition;
  decomposition.setThreshold(1e-8);
  decomposition.compute(jacobian.transpose());
  const VectorX scaled = decomposition.solve(needed);
  int r = 0;
  for (const Closure<S>& closure : full_tree_.closures)
    for (const ClosureRow& row : closure.rows) {
      out[r] = scaled[r] * compute_row_scale(full_tree_, closure, row);
      ++r;
    }
}

template <class S>
bool LoopDynamics<S>::reset_spherical_references(double limit, double* y, double* dy) {
  bool any = false;
  for (const NodeId spherical : full_tree_.spherical_joints) {
    const double middle = std::remainder(y[full_tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    const Tree<S> before = full_tree_;
    const VectorX y_before = Eigen::Map<const VectorX>(y, columns());
    reset_spherical_reference(full_tree_, spherical, y);
    tree_.nodes[spherical].R_PF = full_tree_.nodes[spherical].R_PF;
    transfer_spherical_rates(before, y_before.data(), full_tree_, y, spherical, dy);
    any = true;
  }
  return any;
}

template <class S>
double LoopDynamics<S>::residual() const {
  double worst = 0;
  for (const Closure<S>& closure : full_tree_.closures) {
    if (closure.is_velocity_level()) break;
    const ClosurePose<S> pose = closure_pose(state_, closure);
    for (const ClosureRow& row : closure.rows)
      worst = std::max(worst, std::abs(compute_row_scale(full_tree_, closure, row) * closure_residual(pose, row)));
  }
  return worst;
}

#define BALANCE_INSTANTIATE(S)                                                                          \
  template bool LoopDynamics<S>::reset_spherical_references(double, double*, double*);                  \
  template double LoopDynamics<S>::residual() const;                                                    \
  template void LoopDynamics<S>::weigh_columns();                                                       \
  template std::vector<int> LoopDynamics<S>::preferred_columns() const;                                 \
  template bool LoopDynamics<S>::choose_independent_columns(const double*, bool);                       \
  template void LoopDynamics<S>::select_closure_rows(const std::vector<int>&);                          \
  template MotionOutcome LoopDynamics<S>::assemble(const VectorX&, const VectorX&, VectorX&, VectorX&); \
  template double LoopDynamics<S>::mobility();                                                          \
  template void LoopDynamics<S>::multipliers(const double*, const double*, const double*, std::vector<double>&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
