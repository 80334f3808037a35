#include "balance/mechanics/kinematics/kinematic_equations.hpp"

#include "balance/foundation/numerics/engine_scalar.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace balance::kinematics {

template <class S>
KinematicEquations<S>::KinematicEquations(const Tree<Constants<S>>& tree, const Drive<Constants<S>>& drive,
                                          bool redundant)
    : tree_(tree), drive_(drive), redundant_(redundant), masses_(tree) {
  for (const Closure<Constants<S>>& closure : tree.closures)
    for (const ClosureRow& row : closure.rows) row_scale_.push_back(compute_row_scale(tree, closure, row));
  row_scale_.insert(row_scale_.end(), drive.point.size() + drive.com.size(), 1 / tree.characteristic_length);
  for (const LinearQuantityOf<ModelScalarOf<T>>& quantity : drive.linear)
    row_scale_.push_back(quantity.is_length ? 1 / tree.characteristic_length : 1);
  row_scale_.insert(row_scale_.end(), drive.rotation.size(), 1);
  for (int c = 0; c < tree.columns; ++c)
    column_scale_.push_back(tree.is_length_column[c] ? tree.characteristic_length : 1);
  for (const Node<Constants<S>>& node : tree.nodes)
    node_scale_.push_back(node.column < 0 ? 0 : column_scale_[node.column]);
  for (std::size_t n = 1; n < tree.nodes.size(); ++n)
    if (tree.nodes[n].motion != NodeMotion::weld) moving_nodes_.push_back(static_cast<int>(n));
  build_pattern();
}

template <class S>
std::vector<typename KinematicEquations<S>::MatrixEntry> KinematicEquations<S>::make_row_entries(
    const std::vector<NodeId>& nodes, int row) {
  std::vector<MatrixEntry> entries;
  std::set<int> visited_columns;
  for (const NodeId n : nodes) {
    const int column = tree_.nodes[n].column;
    entries.push_back({entry_index(row, column), !visited_columns.insert(column).second});
  }
  return entries;
}

template <class S>
void KinematicEquations<S>::build_pattern() {
  std::vector<std::set<int>> columns_per_row(static_cast<std::size_t>(rows()));
  const auto mark_columns = [&](int row, const std::vector<NodeId>& nodes) {
    for (const NodeId n : nodes) columns_per_row[row].insert(tree_.nodes[n].column);
  };
  std::vector<std::vector<NodeId>> paths;
  int row = 0;
  for (const Closure<Constants<S>>& closure : tree_.closures) {
    std::vector<NodeId> nodes;
    for (const PathStep& step : closure.path) nodes.push_back(step.node);
    for (std::size_t r = 0; r < closure.rows.size(); ++r) mark_columns(row++, nodes);
    paths.push_back(nodes);
  }
  for (std::size_t k = 0; k < drive_.point.size(); ++k) mark_columns(row++, drive_.tool_path);
  for (std::size_t k = 0; k < drive_.com.size(); ++k) mark_columns(row++, moving_nodes_);
  for (const LinearQuantityOf<ModelScalarOf<T>>& quantity : drive_.linear) {
    for (const auto& [column, coefficient] : quantity.terms) columns_per_row[row].insert(column);
    ++row;
  }
  for (std::size_t k = 0; k < drive_.rotation.size(); ++k) mark_columns(row++, drive_.tool_path);

  numerics::SparsityPattern pattern;
  for (const std::set<int>& row_columns : columns_per_row) pattern.emplace_back(row_columns.begin(), row_columns.end());
  if (redundant_)
    overdetermined_.resize(rows(), columns());
  else
    structurally_singular_ = rows() != columns() || !square_.analyse(pattern);
  if (structurally_singular_) return;
  pattern_id_ = 2 * numerics::hash_pattern(pattern) + (redundant_ ? 1 : 0);

  row = 0;
  for (std::size_t c = 0; c < paths.size(); ++c) {
    const std::size_t count = tree_.closures[c].rows.size();
    std::vector<MatrixEntry> entries(count * paths[c].size());
    for (std::size_t r = 0; r < count; ++r) {
      const std::vector<MatrixEntry> row_entries = make_row_entries(paths[c], row++);
      for (std::size_t step = 0; step < row_entries.size(); ++step) entries[step * count + r] = row_entries[step];
    }
    closure_entries_.push_back(entries);
  }
  for (std::size_t k = 0; k < drive_.point.size(); ++k)
    point_entries_.push_back(make_row_entries(drive_.tool_path, row++));
  for (std::size_t k = 0; k < drive_.com.size(); ++k) com_entries_.push_back(make_row_entries(moving_nodes_, row++));
  for (const LinearQuantityOf<ModelScalarOf<T>>& quantity : drive_.linear) {  // constant entries, written once
    for (const auto& [column, coefficient] : quantity.terms)
      storage()[entry_index(row, column)] += coefficient * row_scale_[row] * column_scale_[column];
    ++row;
  }
  for (std::size_t k = 0; k < drive_.rotation.size(); ++k)
    rotation_entries_.push_back(make_row_entries(drive_.tool_path, row++));
}

template <class S>
void KinematicEquations<S>::evaluate(const TreeState<S>& state, const T* y, const trajectory::DriveSampleOf<T>& target,
                                     T* residual) {
  ++evaluations_;
  fill_closures(state, residual);
  int row = tree_.closure_rows;
  if (!drive_.point.empty()) fill_point(state, target, residual + row);
  row += static_cast<int>(drive_.point.size());
  if (!drive_.com.empty()) fill_com(state, target, residual + row);
  row += static_cast<int>(drive_.com.size());
  int k = static_cast<int>(drive_.point.size() + drive_.com.size());
  for (const LinearQuantityOf<ModelScalarOf<T>>& quantity : drive_.linear) {
    residual[row] = row_scale_[row] * (quantity.value(y) - target.value[k++]);
    ++row;
  }
  if (!drive_.rotation.empty()) fill_rotation(state, target, residual + row);
}

template <class S>
void KinematicEquations<S>::fill_closures(const TreeState<S>& state, T* residual) {
  constexpr std::size_t max_closure_rows = S::dimension + S::angular_dimension;
  const double inverse_length = 1 / tree_.characteristic_length;
  T* values = storage();
  for (std::size_t c = 0; c < tree_.closures.size(); ++c) {
    const Closure<Constants<S>>& closure = tree_.closures[c];
    const ClosurePose<S> pose = closure_pose(state, closure);
    const MatrixEntry* entry = closure_entries_[c].data();
    if (is_point_closure(closure)) {
      for (int i = 0; i < S::dimension; ++i) *residual++ = inverse_length * (pose.p_B[i] - pose.p_A[i]);
      for (const PathStep& step : closure.path) {
        const typename S::Vector v = inverse_length * step.sign * node_scale_[step.node] *
                                     partial_velocity(tree_.nodes[step.node], state[step.node], pose.p_B);
        for (int i = 0; i < S::dimension; ++i, ++entry)
          values[entry->index] = entry->is_accumulated ? values[entry->index] + v[i] : v[i];
      }
      continue;
    }
    if (!closure.terms.empty()) {
      evaluate_speed_sum(closure, state, entry);
      residual = std::fill_n(residual, closure.rows.size(), T(0));
      continue;
    }
    const std::size_t rows = closure.rows.size();
    ConstraintWrench<S> wrenches[max_closure_rows];
    for (std::size_t r = 0; r < rows; ++r) {
      const bool is_angle = closure.rows[r].kind == ClosureRow::Kind::dot;
      wrenches[r] = closure_wrench(closure, pose, closure.rows[r]);
      if (!is_angle) wrenches[r].force *= inverse_length, wrenches[r].moment *= inverse_length;
      *residual++ = (is_angle ? 1 : inverse_length) * closure_residual(pose, closure.rows[r]);
    }
    for (const PathStep& step : closure.path) {
      const Node<Constants<S>>& node = tree_.nodes[step.node];
      const double scale = step.sign * node_scale_[step.node];
      for (std::size_t r = 0; r < rows; ++r, ++entry) {
        const T value = scale * wrench_power(node, state[step.node], pose.p_B, wrenches[r]);
        values[entry->index] = entry->is_accumulated ? values[entry->index] + value : value;
      }
    }
  }
}

template <class S>
void KinematicEquations<S>::evaluate_speed_sum(const Closure<Constants<S>>& closure, const TreeState<S>& state,
                                               const MatrixEntry* entry) {
  if (closure.rows.empty()) return;
  for (const PathStep& step : closure.path)
    write_entry(*entry++,
                node_scale_[step.node] / closure.row_scale * speed_term_coefficient(tree_, state, closure, step));
}

template <class S>
void KinematicEquations<S>::fill_point(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target,
                                       T* residual) {
  const double inverse_length = 1 / tree_.characteristic_length;
  T* values = storage();
  const typename S::Vector Q = position(state, drive_.tool);
  const std::size_t rows = drive_.point.size();
  for (std::size_t k = 0; k < rows; ++k) residual[k] = inverse_length * (Q[drive_.point[k]] - target.value[k]);
  for (std::size_t step = 0; step < drive_.tool_path.size(); ++step) {
    const int n = drive_.tool_path[step];
    const typename S::Vector v = inverse_length * node_scale_[n] * partial_velocity(tree_.nodes[n], state[n], Q);
    for (std::size_t k = 0; k < rows; ++k) {
      const MatrixEntry& entry = point_entries_[k][step];
      values[entry.index] = entry.is_accumulated ? values[entry.index] + v[drive_.point[k]] : v[drive_.point[k]];
    }
  }
}

template <class S>
void KinematicEquations<S>::fill_com(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target,
                                     T* residual) {
  masses_.update(tree_, state);
  const typename S::Vector G = masses_.com();
  const std::size_t first = drive_.point.size();
  for (std::size_t k = 0; k < drive_.com.size(); ++k)
    residual[k] = (G[drive_.com[k]] - target.value[first + k]) / tree_.characteristic_length;
  for (std::size_t i = 0; i < moving_nodes_.size(); ++i) {
    const int n = moving_nodes_[i];
    const typename S::Vector gradient =
        node_scale_[n] / tree_.characteristic_length * masses_.com_gradient(tree_.nodes[n], state[n], n);
    for (std::size_t k = 0; k < drive_.com.size(); ++k) write_entry(com_entries_[k][i], gradient[drive_.com[k]]);
  }
}

template <class S>
void KinematicEquations<S>::fill_rotation(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target,
                                          T* residual) {
  const RotationResidual<T> rotation_residual(target.rotation, to_matrix(orientation(state, drive_.tool)));
  rotation_jacobian_ = rotation_residual.jacobian;
  for (std::size_t k = 0; k < drive_.rotation.size(); ++k) {
    residual[k] = rotation_residual.residual[drive_.rotation[k]];
    const MatrixEntry* entry = rotation_entries_[k].data();
    for (const int n : drive_.tool_path) {
      const bool is_revolute = tree_.nodes[n].motion == NodeMotion::revolute;
      write_entry(
          *entry++,
          is_revolute
              ? node_scale_[n] * tree_.nodes[n].ratio *
                    rotation_residual.jacobian.row(drive_.rotation[k]).dot(angular_to_3d(revolute_axis(state[n].R_WN)))
              : T(0));
    }
  }
}

template <class S>
bool KinematicEquations<S>::factorise(double min_pivot) {
  factorised_evaluation_ = evaluations_;
  regularity_ = redundant_ ? overdetermined_.factorise() : square_.factorise();
  return regularity_ > min_pivot;
}

template <class S>
void KinematicEquations<S>::store() {
  if (redundant_)
    overdetermined_.keep();
  else
    square_.store();
}

template <class S>
bool KinematicEquations<S>::is_near_stored(double limit) {
  return redundant_ ? overdetermined_.near_kept(limit) : square_.is_near_stored(limit);
}

template <class S>
void KinematicEquations<S>::solve(T* x) {
  if (redundant_)
    overdetermined_.solve(x);
  else
    square_.solve(x);
  for (int c = 0; c < columns(); ++c) x[c] *= column_scale_[c];
}

template <class S>
void KinematicEquations<S>::solve_pair(T* x, T* z) {
  if (redundant_) {
    solve(x);
    return solve(z);
  }
  square_.solve_pair(x, z);
  for (int c = 0; c < columns(); ++c) x[c] *= column_scale_[c], z[c] *= column_scale_[c];
}

template <class S>
void KinematicEquations<S>::solve_transposed(T* x) {
  for (int c = 0; c < columns(); ++c) x[c] *= column_scale_[c];
  square_.solve_transposed(x);
  for (int r = 0; r < rows(); ++r) x[r] *= row_scale_[r];
}

namespace {

/// The value of a sum of speeds that a constraint prescribes, with its time derivative.
template <class ClosureType, class Target>
model::ValueAndRate constrained_speed(const ClosureType& closure, const Target& target) {
  return std::isnan(target.constraint_time) ? model::ValueAndRate{}
                                            : model::evaluate_at_time(closure.value, target.constraint_time);
}

}  // namespace

template <class S>
void KinematicEquations<S>::velocity_rhs(const trajectory::DriveSampleOf<T>& target, T* out) const {
  int row = 0;
  for (const Closure<Constants<S>>& closure : tree_.closures)
    for (std::size_t r = 0; r < closure.rows.size(); ++r, ++row)
      out[row] = closure.value ? row_scale_[row] * constrained_speed(closure, target).value : 0;
  for (int k = 0; k < drive_.value_count(); ++k, ++row) out[row] = row_scale_[row] * target.rate[k];
  for (const int component : drive_.rotation)
    out[row++] = rotation_jacobian_.col(component).dot(target.angular_velocity);
}

template <class S>
void KinematicEquations<S>::acceleration_rhs(const TreeState<S>& state, const trajectory::DriveSampleOf<T>& target,
                                             T* out) const {
  int row = 0;
  for (const Closure<Constants<S>>& closure : tree_.closures) {
    closure_bias(state, closure, closure_pose(state, closure), out + row);
    if (closure.value && !closure.rows.empty()) out[row] -= constrained_speed(closure, target).rate;
    for (std::size_t r = 0; r < closure.rows.size(); ++r, ++row) out[row] *= -row_scale_[row];
  }
  int k = 0;
  if (!drive_.point.empty()) {
    const typename S::Vector a = point_acceleration<S>(state[drive_.tool.node], drive_.tool.p_N);
    for (const int component : drive_.point)
      out[row] = row_scale_[row] * (target.acceleration[k++] - a[component]), ++row;
  }
  if (!drive_.com.empty()) {
    const typename S::Vector a = com_acceleration(tree_, state);
    for (const int component : drive_.com)
      out[row] = row_scale_[row] * (target.acceleration[k++] - a[component]), ++row;
  }
  for (std::size_t i = 0; i < drive_.linear.size(); ++i, ++row) out[row] = row_scale_[row] * target.acceleration[k++];
  if (!drive_.rotation.empty()) {
    const NodeState<S>& tool = state[drive_.tool.node];
    const Vector3Of<T> w = angular_to_3d(typename S::Angular(tool.R_WN * tool.angular_velocity));
    const Vector3Of<T> alpha = angular_to_3d(typename S::Angular(tool.R_WN * tool.angular_acceleration));
    const Matrix3Of<T> rate = compute_rotation_jacobian_rate(target.rotation, target.angular_velocity,
                                                             to_matrix(orientation(state, drive_.tool)), w);
    for (const int component : drive_.rotation)
      out[row++] = rotation_jacobian_.col(component).dot(target.angular_acceleration) +
                   rate.col(component).dot(target.angular_velocity) - rotation_jacobian_.row(component).dot(alpha) -
                   rate.row(component).dot(w);
  }
}

template class KinematicEquations<PlanarOf<EngineScalar>>;
template class KinematicEquations<SpatialOf<EngineScalar>>;

}  // namespace balance::kinematics
