#include "balance/control/loop_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

constexpr double dependent_residual_tolerance = 4e-15;   // scaled residual after which one correction is the last
constexpr double stagnation_residual_tolerance = 1e-12;  // below this a residual that hardly shrinks has met round-off
constexpr double acceleration_residual_tolerance = 1e-12;  // the same, in the accelerations that are left uncorrected
constexpr double second_order_threshold = 1e-8;   // above this the second derivative of the closures is worth its cost
constexpr double max_dependent_correction = 0.2;  // of a warm start, in radians or characteristic lengths
constexpr int max_dependent_iterations = 8;

}  // namespace

template <class S>
LoopDynamics<S>::LoopDynamics(const Mechanism& mechanism, const ForwardOptions& options)
    : mechanism_(mechanism),
      options_(options),
      full_tree_(compile_tree<S>(mechanism, options.preferred)),
      tree_(full_tree_),
      external_(mechanism, full_tree_),
      composite_(full_tree_),
      gravity_(to_vector<S>(mechanism.gravity)),
      ground_extent_(ground_extent(mechanism)),
      state_(full_tree_.nodes.size()),
      wrenches_(full_tree_.nodes.size()) {
  options.validate();
  const int n = columns();
  for (const NodeId spherical : full_tree_.spherical_joints) reference_.push_back(full_tree_.nodes[spherical].R_PF);
  for (int c = 0; c < n; ++c) scale_.push_back(full_tree_.is_length_column[c] ? full_tree_.characteristic_length : 1);
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a)
    for (const auto& [column, ratio] : full_tree_.coordinate_expressions[mechanism.actuators[a]].terms)
      driven_.push_back({a, column, ratio});
  for (const Friction& friction : mechanism.friction) {
    const LinearQuantity& source = full_tree_.coordinate_expressions[friction.coordinate];
    const double unit = source.is_length ? full_tree_.characteristic_length : 1;
    frictions_.push_back({friction, source, unit, options.friction_regularisation_speed * unit});
    if (!frictions_.back().has_dry_friction()) continue;
    dry_ = true;
    if (!source.has_single_term())
      throw std::invalid_argument("dry friction in '" + mechanism.coordinates[friction.coordinate].name +
                                  "', which follows several coordinates: whether it sticks cannot be computed");
  }
  const std::size_t most = static_cast<std::size_t>(n) + static_cast<std::size_t>(full_tree_.closure_rows);
  x_.assign(most, 0), rates_.assign(most, 0);
  weigh_columns();
  mass_.assign(n * n, 0), tau_.assign(n, 0), ddy0_.assign(n, 0), joint_springs_.assign(n, 0);
}

/// The poses alone do not tell how often a joint has turned.
template <class S>
void LoopDynamics<S>::update_joint_springs(const double* y) {
  std::fill(joint_springs_.begin(), joint_springs_.end(), 0);
  external_.add_joint_springs(y, joint_springs_.data());
}

template <class S>
bool LoopDynamics<S>::solve_dependent(double* y, double* dy) {
  iterations_ = 0;
  if (is_open_tree()) {
    compute_poses(tree_, y, state_);
    update_joint_springs(y);
    return true;
  }
  const int d = freedoms_, n = columns(), rows = tree_.closure_rows;
  for (int k = 0; k < d; ++k) {
    sample_.value[k] = y[columns_[k]];
    sample_.rate[k] = dy[columns_[k]];
  }
  double last = INFINITY, moved = 0;
  for (; iterations_ <= max_dependent_iterations; ++iterations_) {
    if (iterations_ == 0)
      compute_poses(tree_, y, state_);
    else
      dependent_poses(y);
    equations_->evaluate(state_, y, sample_, x_.data());
    double worst = 0;
    for (int r = 0; r < rows; ++r) worst = std::max(worst, std::abs(x_[r]));
    if (!std::isfinite(worst) || !equations_->factorise()) return false;
    // either small, or as small as round-off allows: the last correction is too small to show in the poses
    const double regularity = std::min(1.0, equations_->regularity());
    const bool last_one =
        worst <= ground_extent_ * std::max(dependent_residual_tolerance,
                                           acceleration_residual_tolerance * regularity * regularity) ||
        (worst <= stagnation_residual_tolerance * ground_extent_ && worst > 0.25 * last);
    if (last_one) {
      equations_->velocity_rhs(sample_, rates_.data());
      equations_->solve_pair(x_.data(), rates_.data());
    } else {
      equations_->solve(x_.data());
    }
    for (int c = 0; c < n; ++c) {
      y[c] -= x_[c];
      moved = std::max(moved, std::abs(x_[c]) / scale_[c]);
    }
    for (int k = 0; k < d; ++k) y[columns_[k]] = sample_.value[k];
    if (moved > max_dependent_correction) return false;
    if (worst > second_order_threshold) apply_second_order_correction(y);
    if (last_one) {
      for (int c = 0; c < n; ++c) dy[c] = rates_[c];
      for (int k = 0; k < d; ++k) dy[columns_[k]] = sample_.rate[k];
      update_joint_springs(y);
      return true;
    }
    last = worst;
  }
  return false;
}

/// Poses once more, after a change of the dependent coordinates only.
template <class S>
void LoopDynamics<S>::dependent_poses(const double* y) {
  for (std::size_t n = 1; n < tree_.nodes.size(); ++n) {
    if (is_dependent_node_[n]) set_local_pose(tree_.nodes[n], y, state_[n]);
    set_world_pose(state_[tree_.nodes[n].parent], state_[n]);
  }
}

/// After a Newton step −δ the closures are left with ½ δᵀΦ″δ, which is the second derivative that velocities δ alone make: Chebyshev's
/// third-order step costs less than another evaluation of the poses.
template <class S>
void LoopDynamics<S>::apply_second_order_correction(double* y) {
  compute_angular_velocities(tree_, x_.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, x_.data(), state_);
  compute_accelerations<S>(tree_, x_.data(), nullptr, S::Vector::Zero(), state_);
  equations_->acceleration_rhs(state_, sample_, x_.data());
  equations_->solve(x_.data());
  for (int c = 0; c < columns(); ++c) y[c] += x_[c] / 2;
  for (int k = 0; k < freedoms_; ++k) y[columns_[k]] = sample_.value[k];
}

template <class S>
void LoopDynamics<S>::compute_tree_terms(double time, const double* dy) {
  compute_angular_velocities(tree_, dy, state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, dy, state_);
  // The ground accelerated by −g carries the weight into the inertia forces; in the closures' differences it cancels.
  compute_accelerations<S>(tree_, dy, nullptr, -gravity_, state_);
  if (is_open_tree()) {
    std::fill(ddy0_.begin(), ddy0_.end(), 0);
  } else {
    equations_->acceleration_rhs(state_, sample_, x_.data());
    unit_rows(0, rates_);  // the first column of C is solved for in the same go
    equations_->solve_pair(x_.data(), rates_.data());
    std::copy_n(x_.data(), columns(), ddy0_.data());
    store_transformation_column(0, rates_);
  }
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  if (!external_.is_empty()) external_.subtract(state_, time, wrenches_, total, loads);
  inverse_dynamics(tree_, state_, wrenches_, tau_.data());
  for (int c = 0; c < columns(); ++c) tau_[c] += joint_springs_[c];
  if (!frictions_.empty()) add_friction(dy);
  composite_.compute_mass_matrix(tree_, state_, mass_.data());
}

/// Right-hand side of the rates that a unit rate of one independent coordinate causes; nothing beyond the last.
template <class S>
void LoopDynamics<S>::unit_rows(int k, std::vector<double>& rows) const {
  std::fill(rows.begin(), rows.end(), 0.0);
  const int row = tree_.closure_rows + k;
  if (k < freedoms_) rows[row] = equations_->row_scale()[row];
}

template <class S>
void LoopDynamics<S>::store_transformation_column(int k, const std::vector<double>& rates) {
  if (k >= freedoms_) return;
  for (int c = 0; c < columns(); ++c) C_[c * freedoms_ + k] = rates[c];
}

template <class S>
void LoopDynamics<S>::reduce_to_independent() {
  const int n = columns(), d = freedoms_;
  if (is_open_tree()) {
    for (int c = 0; c < n; ++c)
      for (int k = 0; k < d; ++k) C_[c * d + k] = columns_[k] == c;
    for (int a = 0; a < d; ++a) {
      bias_[a] = tau_[columns_[a]];
      for (int b = 0; b < d; ++b) M_(a, b) = mass_[columns_[a] * n + columns_[b]];
    }
    return;
  }
  for (int k = 1; k < d; k += 2) {  // the first one is known from prepare()
    unit_rows(k, x_);
    unit_rows(k + 1, rates_);
    equations_->solve_pair(x_.data(), rates_.data());
    store_transformation_column(k, x_);
    store_transformation_column(k + 1, rates_);
  }
  double* HC = HC_.data();
  for (int i = 0; i < n; ++i) {
    double* row = HC + i * d;
    for (int k = 0; k < d; ++k) row[k] = 0;
    double sum = tau_[i];
    for (int j = 0; j < n; ++j) {
      const double h = mass_[i * n + j];
      if (h == 0) continue;
      sum += h * ddy0_[j];
      for (int k = 0; k < d; ++k) row[k] += h * C_[j * d + k];
    }
    x_[i] = sum;
  }
  for (int a = 0; a < d; ++a) {
    bias_[a] = 0;
    for (int b = 0; b <= a; ++b) M_(a, b) = 0;
  }
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < d; ++a) {
      const double c = C_[i * d + a];
      if (c == 0) continue;
      bias_[a] += c * x_[i];
      for (int b = 0; b <= a; ++b) M_(a, b) += c * HC[i * d + b];
    }
  for (int a = 0; a < d; ++a)
    for (int b = 0; b < a; ++b) M_(b, a) = M_(a, b);
}

namespace {

/// x := A⁻¹ x by Cholesky's factors of the few rows that there are; A's lower triangle on entry, the factor on return.
bool solve_cholesky(double* A, double* x, int d) {
  for (int i = 0; i < d; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = A[i * d + j];
      for (int k = 0; k < j; ++k) sum -= A[i * d + k] * A[j * d + k];
      if (i == j) {
        if (!(sum > 0)) return false;
        A[i * d + i] = 1 / std::sqrt(sum);
      } else {
        A[i * d + j] = sum * A[j * d + j];
      }
    }
  }
  for (int i = 0; i < d; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= A[i * d + k] * x[k];
    x[i] *= A[i * d + i];
  }
  for (int i = d - 1; i >= 0; --i) {
    for (int k = i + 1; k < d; ++k) x[i] -= A[k * d + i] * x[k];
    x[i] *= A[i * d + i];
  }
  return true;
}

}  // namespace

template <class S>
bool LoopDynamics<S>::accelerate(double time, const double* dy, const double* efforts, double* ddy) {
  compute_tree_terms(time, dy);
  reduce_to_independent();
  const int n = columns(), d = freedoms_;
  for (int k = 0; k < d; ++k) right_[k] = -bias_[k];
  for (const ActuatedColumn& driven : driven_) {
    const double force = driven.ratio * efforts[driven.actuator];
    if (force == 0) continue;
    for (int k = 0; k < d; ++k) right_[k] += C_[driven.column * d + k] * force;
  }
  for (int a = 0; a < d; ++a)
    for (int b = 0; b <= a; ++b) factor_[a * d + b] = M_(a, b);
  if (is_any_sticking()) fix_sticking_accelerations();
  if (!solve_cholesky(factor_.data(), right_.data(), d)) return false;
  bool finite = true;
  for (int c = 0; c < n; ++c) {
    double sum = ddy0_[c];
    for (int k = 0; k < d; ++k) sum += C_[c * d + k] * right_[k];
    ddy[c] = sum;
    finite = finite && std::isfinite(sum);
  }
  return finite;
}

template class LoopDynamics<Planar>;
template class LoopDynamics<Spatial>;

}  // namespace balance
