#include "balance/mechanics/dynamics/loop_dynamics.hpp"

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace balance::dynamics {

/// Columns of a matrix that determine the others, by QR decompositions with column pivoting (Businger and Golub, Numer.
/// Math. 7, 1965).
double compute_reciprocal_condition(const MatrixX& matrix);  ///< smallest over largest singular value
MatrixX select_columns(const MatrixX& matrix, const std::vector<int>& columns);
std::vector<int> complement_indices(const std::vector<int>& indices, int n);  ///< of 0 … n − 1

/// Columns of the first `count` pivots, in increasing order. @param last ratio of the last pivot to the first
std::vector<int> pivot_columns(const MatrixX& matrix, int count, double& last);

/// The same, but with columns of sticking joints only if the others do not suffice: every motion that is possible while
/// these joints stick is then determined by the independent columns that do not stick.
std::vector<int> pivot_moving_columns(const MatrixX& matrix, int count, const std::vector<bool>& is_sticking);

namespace {

constexpr double moving_pivot_tolerance =
    1e-5;  // smallest pivot, relative to the largest column, of a moving column that may be dependent

}  // namespace

double compute_reciprocal_condition(const MatrixX& matrix) {
  if (matrix.size() == 0) return 1;
  const VectorX values = numerics::singular_values(matrix);
  return values[0] > 0 ? values[values.size() - 1] / values[0] : 0;
}

MatrixX select_columns(const MatrixX& matrix, const std::vector<int>& columns) {
  MatrixX out(matrix.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = matrix.col(columns[k]);
  return out;
}

std::vector<int> complement_indices(const std::vector<int>& indices, int n) {
  std::vector<int> out;
  for (int c = 0; c < n; ++c)
    if (std::find(indices.begin(), indices.end(), c) == indices.end()) out.push_back(c);
  return out;
}

/// Columns of the first `count` pivots of a QR decomposition with column pivoting.
std::vector<int> pivot_columns(const MatrixX& matrix, int count, double& last) {
  const numerics::ColumnPivotingQr qr(matrix);
  std::vector<int> out;
  last = 1;
  for (int k = 0; k < count; ++k) {
    out.push_back(qr.colsPermutation().indices()[k]);
    last = std::abs(qr.matrixQR()(k, k) / qr.matrixQR()(0, 0));
  }
  if (!(last == last)) last = 0;
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<int> pivot_moving_columns(const MatrixX& matrix, int count, const std::vector<bool>& is_sticking) {
  std::vector<int> moving, standing, out;
  for (int c = 0; c < static_cast<int>(matrix.cols()); ++c)
    (is_sticking[static_cast<std::size_t>(c)] ? standing : moving).push_back(c);
  MatrixX standing_columns = select_columns(matrix, standing);
  const double max_norm = numerics::max_abs(matrix.colwise().norm());
  int pivot_count = 0;
  if (!moving.empty()) {
    const numerics::ColumnPivotingQr qr(select_columns(matrix, moving));
    const auto max_pivots = static_cast<int>(std::min(qr.matrixQR().rows(), qr.matrixQR().cols()));
    for (; pivot_count < std::min(count, max_pivots) &&
           std::abs(qr.matrixQR()(pivot_count, pivot_count)) > moving_pivot_tolerance * max_norm;
         ++pivot_count)
      out.push_back(moving[static_cast<std::size_t>(qr.colsPermutation().indices()[pivot_count])]);
    standing_columns.applyOnTheLeft(qr.householderQ().adjoint());
  }
  if (pivot_count < count && !standing.empty()) {
    const MatrixX remainder = standing_columns.bottomRows(standing_columns.rows() - pivot_count);
    double last;
    for (const int c : pivot_columns(remainder, count - pivot_count, last))
      out.push_back(standing[static_cast<std::size_t>(c)]);
  }
  std::sort(out.begin(), out.end());
  return out;
}

namespace {

constexpr double dependent_residual_tolerance = 4e-15;     // scaled residual below which one correction is the last
constexpr double stagnation_residual_tolerance = 1e-12;    // below this a residual that hardly shrinks is round-off
constexpr double acceleration_residual_tolerance = 1e-12;  // the same, as error of the accelerations
constexpr double second_order_threshold = 1e-8;   // above this the second derivative of the closures is worth its cost
constexpr double max_dependent_correction = 0.2;  // of a warm start, in radians or characteristic lengths
constexpr int max_dependent_iterations = 8;

}  // namespace

template <class S>
LoopDynamics<S>::LoopDynamics(const Mechanism& mechanism, const ForwardOptions& options)
    : mechanism_(mechanism),
      options_(options),
      full_tree_(kinematics::compile_tree<S>(mechanism, options.preferred)),
      tree_(full_tree_),
      external_(mechanism, full_tree_),
      composite_(full_tree_),
      gravity_(kinematics::to_vector<S>(mechanism.gravity)),
      ground_extent_(ground_extent(mechanism)),
      state_(full_tree_.nodes.size()),
      wrenches_(full_tree_.nodes.size()) {
  options.validate();
  const int n = columns();
  for (const kinematics::NodeId spherical : full_tree_.spherical_joints)
    reference_.push_back(full_tree_.nodes[spherical].R_PF);
  for (int c = 0; c < n; ++c) scale_.push_back(full_tree_.is_length_column[c] ? full_tree_.characteristic_length : 1);
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a)
    for (const auto& [column, ratio] : full_tree_.coordinate_expressions[mechanism.actuators[a]].terms)
      actuated_columns_.push_back({a, column, ratio});
  for (const Friction& friction : mechanism.friction) {
    const kinematics::LinearQuantity& source = full_tree_.coordinate_expressions[friction.coordinate];
    const double unit = source.is_length ? full_tree_.characteristic_length : 1;
    frictions_.push_back({friction, source, unit, options.friction_regularisation_speed * unit});
    if (!frictions_.back().has_dry_friction()) continue;
    has_dry_friction_ = true;
    if (has_prescribed_speeds(mechanism))
      throw std::invalid_argument("dry friction in '" + mechanism.coordinates[friction.coordinate].name +
                                  "' of a mechanism whose constraints prescribe speeds: whether it sticks cannot be "
                                  "computed");
    if (!source.has_single_term())
      throw std::invalid_argument("dry friction in '" + mechanism.coordinates[friction.coordinate].name +
                                  "', which follows several coordinates: whether it sticks cannot be computed");
  }
  const std::size_t max_rows = static_cast<std::size_t>(n) + static_cast<std::size_t>(full_tree_.closure_rows);
  x_.assign(max_rows, 0), rates_.assign(max_rows, 0);
  weigh_columns();
  mass_.assign(n * n, 0), tau_.assign(n, 0), ddy0_.assign(n, 0), joint_springs_.assign(n, 0), y_.assign(n, 0);
}

/// Uses y, because the poses do not determine full turns.
template <class S>
void LoopDynamics<S>::set_coordinates(const double* y) {
  std::copy_n(y, columns(), y_.data());
  std::fill(joint_springs_.begin(), joint_springs_.end(), 0);
  external_.add_joint_springs(y, joint_springs_.data());
}

template <class S>
bool LoopDynamics<S>::solve_dependent(double time, double* y, double* dy) {
  iterations_ = 0;
  sample_.constraint_time = time;
  if (is_open_tree()) {
    compute_poses(tree_, y, state_);
    set_coordinates(y);
    return true;
  }
  const int d = freedoms_, n = columns(), rows = tree_.closure_rows;
  for (int k = 0; k < d; ++k) {
    sample_.value[k] = y[columns_[k]];
    sample_.rate[k] = dy[columns_[k]];
  }
  double previous_residual = INFINITY, correction = 0;
  for (; iterations_ <= max_dependent_iterations; ++iterations_) {
    if (iterations_ == 0)
      compute_poses(tree_, y, state_);
    else
      dependent_poses(y);
    equations_->evaluate(state_, y, sample_, x_.data());
    double max_residual = 0;
    for (int r = 0; r < rows; ++r) max_residual = std::max(max_residual, std::abs(x_[r]));
    if (!std::isfinite(max_residual) || !equations_->factorise()) return false;
    // either small, or as small as round-off allows: the last correction is too small to show in the poses
    const double regularity = std::min(1.0, equations_->regularity());
    const bool is_last =
        max_residual <= ground_extent_ * std::max(dependent_residual_tolerance,
                                                  acceleration_residual_tolerance * regularity * regularity) ||
        (max_residual <= stagnation_residual_tolerance * ground_extent_ && max_residual > 0.25 * previous_residual);
    if (is_last) {
      equations_->velocity_rhs(sample_, rates_.data());
      equations_->solve_pair(x_.data(), rates_.data());
    } else {
      equations_->solve(x_.data());
    }
    for (int c = 0; c < n; ++c) {
      y[c] -= x_[c];
      correction = std::max(correction, std::abs(x_[c]) / scale_[c]);
    }
    for (int k = 0; k < d; ++k) y[columns_[k]] = sample_.value[k];
    if (correction > max_dependent_correction) return false;
    if (max_residual > second_order_threshold) apply_second_order_correction(y);
    if (is_last) {
      for (int c = 0; c < n; ++c) dy[c] = rates_[c];
      for (int k = 0; k < d; ++k) dy[columns_[k]] = sample_.rate[k];
      set_coordinates(y);
      return true;
    }
    previous_residual = max_residual;
  }
  return false;
}

/// Updates the poses after a change of the dependent coordinates only.
template <class S>
void LoopDynamics<S>::dependent_poses(const double* y) {
  for (std::size_t n = 1; n < tree_.nodes.size(); ++n) {
    if (is_dependent_node_[n]) set_local_pose(tree_.nodes[n], y, state_[n]);
    set_world_pose(state_[tree_.nodes[n].parent], state_[n]);
  }
}

/// After a Newton step −δ the closures are left with ½ δᵀΦ″δ, half the second derivative due to velocities δ alone.
/// Chebyshev's third-order step, which removes it, costs less than another evaluation of the poses.
template <class S>
void LoopDynamics<S>::apply_second_order_correction(double* y) {
  compute_angular_velocities(tree_, x_.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, x_.data(), state_);
  kinematics::compute_accelerations<S>(tree_, x_.data(), nullptr, S::Vector::Zero(), state_);
  const double time = std::exchange(sample_.constraint_time, std::numeric_limits<double>::quiet_NaN());
  equations_->acceleration_rhs(state_, sample_, x_.data());
  sample_.constraint_time = time;
  equations_->solve(x_.data());
  for (int c = 0; c < columns(); ++c) y[c] += x_[c] / 2;
  for (int k = 0; k < freedoms_; ++k) y[columns_[k]] = sample_.value[k];
}

template <class S>
void LoopDynamics<S>::compute_tree_terms(double time, const double* dy) {
  compute_angular_velocities(tree_, dy, state_);
  if (tree_.has_sliding_closures || external_.has_dampers()) compute_origin_velocities(tree_, dy, state_);
  // Accelerating the ground by −g adds the weight to the inertia forces; in the closures' differences it cancels.
  kinematics::compute_accelerations<S>(tree_, dy, nullptr, -gravity_, state_);
  if (is_open_tree()) {
    std::fill(ddy0_.begin(), ddy0_.end(), 0);
  } else {
    equations_->acceleration_rhs(state_, sample_, x_.data());
    set_unit_rate_rhs(0, rates_);  // the first column of C is solved for at the same time
    equations_->solve_pair(x_.data(), rates_.data());
    std::copy_n(x_.data(), columns(), ddy0_.data());
    store_transformation_column(0, rates_);
  }
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  if (!external_.is_empty()) external_.subtract(state_, y_.data(), time, wrenches_, total, loads);
  inverse_dynamics(tree_, state_, wrenches_, tau_.data());
  for (int c = 0; c < columns(); ++c) tau_[c] += joint_springs_[c];
  if (!frictions_.empty()) add_friction(dy);
  composite_.compute_mass_matrix(tree_, state_, mass_.data());
}

/// Right-hand side of the rates due to a unit rate of independent coordinate k; zero if k is beyond the last.
template <class S>
void LoopDynamics<S>::set_unit_rate_rhs(int k, std::vector<double>& rows) const {
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
  for (int k = 1; k < d; k += 2) {  // the first one is known from compute_tree_terms()
    set_unit_rate_rhs(k, x_);
    set_unit_rate_rhs(k + 1, rates_);
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

/// x := A⁻¹ x by Cholesky factorisation, for few rows; A holds its lower triangle on entry, the factor on return.
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
  for (int k = 0; k < d; ++k) rhs_[k] = -bias_[k];
  for (const ActuatedColumn& actuated : actuated_columns_) {
    const double force = actuated.ratio * efforts[actuated.actuator];
    if (force == 0) continue;
    for (int k = 0; k < d; ++k) rhs_[k] += C_[actuated.column * d + k] * force;
  }
  for (int a = 0; a < d; ++a)
    for (int b = 0; b <= a; ++b) factor_[a * d + b] = M_(a, b);
  if (is_any_sticking()) fix_sticking_accelerations();
  if (!solve_cholesky(factor_.data(), rhs_.data(), d)) return false;
  bool finite = true;
  for (int c = 0; c < n; ++c) {
    double sum = ddy0_[c];
    for (int k = 0; k < d; ++k) sum += C_[c * d + k] * rhs_[k];
    ddy[c] = sum;
    finite = finite && std::isfinite(sum);
  }
  return finite;
}

template class LoopDynamics<kinematics::Planar>;
template class LoopDynamics<kinematics::Spatial>;

// Choice of the independent coordinates, and assembly from a guess.

namespace {

constexpr double closure_rank_tolerance = 1e-5;       // smallest relative pivot of closures that have their full rank
constexpr double preferred_columns_tolerance = 1e-5;  // the same for the columns dependent on preferred coordinates
// Weights that favour columns as dependent ones: those of spherical joints, whose own coordinates mean little, and
// those that take part in one loop only, which lets the loops be solved one by one.
constexpr double spherical_weight = 10;
constexpr double own_loop_weight = 3;
constexpr double other_column_weight = 1e4;  // of columns that are not preferred as independent ones

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
  if (static_cast<int>(out.size()) < freedoms_) return {};
  return out;
}

/// Of more preferred columns than freedoms, those that determine the others best: the dependent columns are, as far as
/// possible, the others. Empty if that is not possible.
template <class S>
std::vector<int> LoopDynamics<S>::select_preferred(const std::vector<int>& preferred, const MatrixX& jacobian) const {
  if (static_cast<int>(preferred.size()) <= freedoms_) return preferred;
  const auto is_preferred = [&](int column) {
    return std::find(preferred.begin(), preferred.end(), column) != preferred.end();
  };
  MatrixX weighted = jacobian;
  for (int c = 0; c < columns(); ++c)
    if (!is_preferred(c)) weighted.col(c) *= other_column_weight;
  double unused;
  const std::vector<int> independent =
      complement_indices(pivot_columns(weighted, columns() - freedoms_, unused), columns());
  return std::all_of(independent.begin(), independent.end(), is_preferred) ? independent : std::vector<int>();
}

template <class S>
void LoopDynamics<S>::weigh_columns() {
  column_weight_.assign(columns(), own_loop_weight);
  std::vector<int> loops(columns(), 0);
  for (const kinematics::Closure<S>& closure : full_tree_.closures) {
    std::vector<bool> is_on_path(columns(), false);
    for (const kinematics::PathStep& step : closure.path) is_on_path[full_tree_.nodes[step.node].column] = true;
    for (int c = 0; c < columns(); ++c)
      if (is_on_path[c] && ++loops[c] > 1) column_weight_[c] = 1;
  }
  for (const kinematics::NodeId spherical : full_tree_.spherical_joints)
    for (int k = spherical; k < spherical + 3; ++k)
      if (full_tree_.nodes[k].column >= 0) column_weight_[full_tree_.nodes[k].column] = spherical_weight;
}

template <class S>
bool LoopDynamics<S>::choose_independent_columns(const double* y, bool prefer) {
  ++choice_count_;
  const int n = columns(), d = freedoms_, rank = n - d;
  std::vector<int> independent_columns;
  if (prefer) independent_columns = preferred_columns();
  std::vector<int> rows(full_tree_.closure_rows);
  std::iota(rows.begin(), rows.end(), 0);
  if (is_open_tree()) {
    columns_ = static_cast<int>(independent_columns.size()) == n ? independent_columns : complement_indices({}, n);
  } else {
    // a single row of a point closure refers to the joint's axes; a complete set may refer to the world's
    kinematics::Tree<S> axis_tree = full_tree_;
    for (kinematics::Closure<S>& closure : axis_tree.closures)
      closure.has_coincident_origins = closure.has_coincident_origins && !has_redundant_closures();
    kinematics::ConstraintSystem<S> closures(axis_tree, kinematics::Drive<S>{});
    MatrixX jacobian;
    closures.velocity_jacobian(Eigen::Map<const VectorX>(y, n), {}, jacobian);
    MatrixX weighted = jacobian;
    for (int c = 0; c < n; ++c) weighted.col(c) *= column_weight_[c];
    double last;
    std::vector<int> dependent = pivot_columns(weighted, rank, closure_regularity_);
    if (closure_regularity_ < closure_rank_tolerance) return false;
    if (is_any_sticking()) dependent = pivot_moving_columns(weighted, rank, sticking_columns());
    independent_columns = select_preferred(independent_columns, weighted);
    if (!independent_columns.empty() &&
        compute_reciprocal_condition(select_columns(jacobian, complement_indices(independent_columns, n))) >
            preferred_columns_tolerance)
      dependent = complement_indices(independent_columns, n);
    else
      independent_columns = complement_indices(dependent, n);
    columns_ = independent_columns;
    if (has_redundant_closures()) rows = pivot_columns(select_columns(jacobian, dependent).transpose(), rank, last);
  }
  select_closure_rows(rows);
  is_dependent_node_.clear();
  for (const kinematics::Node<S>& node : full_tree_.nodes)
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
  factor_.assign(d * d, 0), rhs_.assign(d, 0);
  if (is_open_tree()) return true;
  equations_.emplace(tree_, drive_, false);
  if (equations_->structurally_singular()) return false;
  VectorX y_now = Eigen::Map<const VectorX>(y, n);
  for (int k = 0; k < d; ++k) sample_.value[k] = y_now[columns_[k]];
  compute_poses(tree_, y_now.data(), state_);
  equations_->evaluate(state_, y_now.data(), sample_, x_.data());
  const bool is_regular_choice = equations_->factorise();
  regularity_at_choice_ = equations_->regularity();
  return is_regular_choice;
}

/// Keeps only these rows of the closures in tree_, on which the equations are based.
template <class S>
void LoopDynamics<S>::select_closure_rows(const std::vector<int>& rows) {
  tree_.closures = full_tree_.closures;
  tree_.closure_rows = static_cast<int>(rows.size());
  tree_.has_sliding_closures = full_tree_.has_sliding_closures;
  if (tree_.closure_rows == full_tree_.closure_rows) return;
  tree_.has_sliding_closures = false;
  int row = 0;
  for (kinematics::Closure<S>& closure : tree_.closures) {
    std::vector<kinematics::ClosureRow> selected_rows;
    int along_count = 0;
    for (const kinematics::ClosureRow& closure_row : closure.rows) {
      if (!std::binary_search(rows.begin(), rows.end(), row++)) continue;
      selected_rows.push_back(closure_row);
      along_count += closure_row.kind == kinematics::ClosureRow::Kind::along;
    }
    closure.rows = selected_rows;
    closure.has_coincident_origins = along_count == S::dimension;
    tree_.has_sliding_closures = tree_.has_sliding_closures || !closure.has_coincident_origins;
  }
}

template <class S>
MotionOutcome LoopDynamics<S>::assemble(double time, const VectorX& q, const VectorX& dq, VectorX& y, VectorX& dy) {
  for (std::size_t b = 0; b < full_tree_.spherical_joints.size(); ++b)
    full_tree_.nodes[full_tree_.spherical_joints[b]].R_PF = tree_.nodes[full_tree_.spherical_joints[b]].R_PF =
        reference_[b];
  reset_friction();
  to_tree_coordinates(mechanism_, full_tree_, q, dq, y, dy);
  reset_spherical_references(0.5, y.data(), dy.data());
  kinematics::ConstraintSystem<S> closures(full_tree_, kinematics::Drive<S>{});
  const kinematics::AssemblySolution nearest = kinematics::solve_assembly(closures, y, {});
  if (!nearest.found)
    return make_outcome(MotionStatus::not_assembled, 0, "the loops do not close near the given joint coordinates");
  if (freedoms_ < 0) freedoms_ = columns() - find_generic_closure_rank(full_tree_, nearest.y);
  const auto make_singular_outcome = [&] {
    return make_outcome(
        MotionStatus::constraint_singularity, 0,
        "constraint singularity: the loop closures lose rank, the mechanism gains a freedom; configuration: " +
            kinematics::format_configuration(mechanism_, q));
  };
  if (!choose_independent_columns(nearest.y.data(), true)) return make_singular_outcome();
  // keep the independent ones as given, if the others can follow
  kinematics::ConstraintSystem<S> driven_system(full_tree_, drive_);
  trajectory::DriveSample target;
  target.value.resize(freedoms_);
  for (int k = 0; k < freedoms_; ++k) target.value[k] = y[columns_[k]];
  const kinematics::AssemblySolution exact = solve_assembly(driven_system, nearest.y, target);
  if (!exact.found)
    return make_outcome(MotionStatus::not_assembled, 0,
                        "the loops do not close with the given independent joint coordinates");
  y = exact.y;
  reset_spherical_references(1, y.data(), dy.data());
  if (!choose_independent_columns(y.data(), true) || !solve_dependent(time, y.data(), dy.data()))
    return make_singular_outcome();
  return {MotionStatus::done, 0, "", {}};
}

template <class S>
double LoopDynamics<S>::mobility() {
  if (is_open_tree()) return 1;
  return equations_->min_singular_value();
}

/// Solves τ = Sᵀu + Jᵀλ, with τ the generalised forces of the tree's motion.
template <class S>
void LoopDynamics<S>::multipliers(const double* efforts, const double* ddy, const double* y, std::vector<double>& out) {
  const int n = columns();
  out.assign(full_tree_.closure_rows, 0);
  if (is_open_tree()) return;
  for (int i = 0; i < n; ++i) {
    x_[i] = tau_[i];
    for (int j = 0; j < n; ++j) x_[i] += mass_[i * n + j] * ddy[j];
  }
  for (const ActuatedColumn& actuated : actuated_columns_)
    x_[actuated.column] -= actuated.ratio * efforts[actuated.actuator];
  if (!has_redundant_closures()) {
    equations_->solve_transposed(x_.data());
    std::copy_n(x_.data(), full_tree_.closure_rows, out.data());
    return;
  }
  kinematics::ConstraintSystem<S> closures(full_tree_, kinematics::Drive<S>{});
  VectorX scaled_forces(n);
  MatrixX jacobian;
  closures.velocity_jacobian(Eigen::Map<const VectorX>(y, n), {}, jacobian);
  for (int c = 0; c < n; ++c) scaled_forces[c] = scale_[c] * x_[c];
  numerics::CompleteOrthogonalDecomposition decomposition;
  decomposition.setThreshold(1e-8);
  decomposition.compute(jacobian.transpose());
  const VectorX scaled_multipliers = decomposition.solve(scaled_forces);
  int r = 0;
  for (const kinematics::Closure<S>& closure : full_tree_.closures)
    for (const kinematics::ClosureRow& row : closure.rows) {
      out[r] = scaled_multipliers[r] * compute_row_scale(full_tree_, closure, row);
      ++r;
    }
}

template <class S>
bool LoopDynamics<S>::reset_spherical_references(double limit, double* y, double* dy) {
  bool was_reset = false;
  for (const kinematics::NodeId spherical : full_tree_.spherical_joints) {
    const double middle = std::remainder(y[full_tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    const kinematics::Tree<S> tree_before = full_tree_;
    const VectorX y_before = Eigen::Map<const VectorX>(y, columns());
    reset_spherical_reference(full_tree_, spherical, y);
    tree_.nodes[spherical].R_PF = full_tree_.nodes[spherical].R_PF;
    transfer_spherical_rates(tree_before, y_before.data(), full_tree_, y, spherical, dy);
    was_reset = true;
  }
  return was_reset;
}

template <class S>
double LoopDynamics<S>::residual() const {
  double max_residual = 0;
  for (const kinematics::Closure<S>& closure : full_tree_.closures) {
    if (closure.is_velocity_level()) break;
    const kinematics::ClosurePose<S> pose = closure_pose(state_, closure);
    for (const kinematics::ClosureRow& row : closure.rows)
      max_residual =
          std::max(max_residual, std::abs(compute_row_scale(full_tree_, closure, row) * closure_residual(pose, row)));
  }
  return max_residual;
}

#define BALANCE_INSTANTIATE(S)                                                                                  \
  template bool LoopDynamics<S>::reset_spherical_references(double, double*, double*);                          \
  template double LoopDynamics<S>::residual() const;                                                            \
  template void LoopDynamics<S>::weigh_columns();                                                               \
  template std::vector<int> LoopDynamics<S>::preferred_columns() const;                                         \
  template std::vector<int> LoopDynamics<S>::select_preferred(const std::vector<int>&, const MatrixX&) const;   \
  template bool LoopDynamics<S>::choose_independent_columns(const double*, bool);                               \
  template void LoopDynamics<S>::select_closure_rows(const std::vector<int>&);                                  \
  template MotionOutcome LoopDynamics<S>::assemble(double, const VectorX&, const VectorX&, VectorX&, VectorX&); \
  template double LoopDynamics<S>::mobility();                                                                  \
  template void LoopDynamics<S>::multipliers(const double*, const double*, const double*, std::vector<double>&);
BALANCE_INSTANTIATE(kinematics::Planar)
BALANCE_INSTANTIATE(kinematics::Spatial)
#undef BALANCE_INSTANTIATE

namespace {

constexpr double inertia_epsilon = 1e-14;  // of the largest inertia: round-off

bool has_singular_inertia(const Body& body) { return body.mass == 0 || body.inertia.isZero(0); }

std::string describe_missing_inertia(const Body& body) {
  return "body '" + body.name + "' has no " + (body.mass == 0 ? "mass" : "moment of inertia");
}

/// The body without inertia at a joint, else all such bodies.
std::string describe_massless_bodies(const Mechanism& mechanism, JointId joint) {
  for (const BodyId body : {mechanism.joints[joint].second, mechanism.joints[joint].first})
    if (body != model::ground && has_singular_inertia(mechanism.bodies[body]))
      return describe_missing_inertia(mechanism.bodies[body]);
  std::string text;
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    if (has_singular_inertia(mechanism.bodies[b]))
      text += (text.empty() ? "" : ", ") + describe_missing_inertia(mechanism.bodies[b]);
  return text;
}

}  // namespace

template <class S>
MotionOutcome check_mass_matrix(const Mechanism& mechanism, LoopDynamics<S>& loops, double time, const double* dy) {
  const MotionOutcome regular{MotionStatus::done, time, "", {}};
  if (std::none_of(mechanism.bodies.begin() + 1, mechanism.bodies.end(), has_singular_inertia) || loops.freedoms() == 0)
    return regular;
  loops.compute_tree_terms(time, dy);
  loops.reduce_to_independent();
  MatrixX mass = loops.reduced_mass();
  for (int a = 0; a < loops.freedoms(); ++a) {
    mass.row(a) *= loops.scale()[loops.independent()[a]];
    mass.col(a) *= loops.scale()[loops.independent()[a]];
  }
  const numerics::SymmetricEigenSolver solver(mass);
  const VectorX& eigenvalues = solver.eigenvalues();  // increasing
  if (eigenvalues[0] > inertia_epsilon * eigenvalues[eigenvalues.size() - 1]) return regular;
  const Eigen::Index free_index = numerics::max_index(solver.eigenvectors().col(0).cwiseAbs());
  const CoordinateId coordinate = find_column_coordinates(loops.tree())[loops.independent()[free_index]];
  return {MotionStatus::actuation_singularity,
          time,
          "the mass matrix is singular: no mass resists an acceleration of " + mechanism.coordinates[coordinate].name +
              "; " + describe_massless_bodies(mechanism, mechanism.coordinates[coordinate].joint),
          {}};
}

template MotionOutcome check_mass_matrix(const Mechanism&, LoopDynamics<kinematics::Planar>&, double, const double*);
template MotionOutcome check_mass_matrix(const Mechanism&, LoopDynamics<kinematics::Spatial>&, double, const double*);

}  // namespace balance::dynamics
