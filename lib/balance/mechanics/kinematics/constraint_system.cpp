#include "balance/mechanics/kinematics/constraint_system.hpp"

namespace balance::kinematics {

template <class S>
ConstraintSystem<S>::ConstraintSystem(const Tree<S>& tree, Drive<S> drive)
    : tree_(tree), drive_(std::move(drive)), state_(tree.nodes.size()), masses_(tree) {}

template <class S>
void ConstraintSystem<S>::evaluate(const VectorX& y, const trajectory::DriveSample& target, VectorX& residual,
                                   MatrixX& jacobian) {
  residual.setZero(rows());
  jacobian.setZero(rows(), columns());
  compute_poses(tree_, y.data(), state_);
  const auto add = [&](int row, int column, double value) { jacobian(row, column) += value; };
  add_closures(residual, add);
  add_drive(y, target, tree_.position_rows, residual, add);
  for (int c = 0; c < columns(); ++c)
    if (tree_.is_length_column[c]) jacobian.col(c) *= tree_.characteristic_length;
}

template <class S>
void ConstraintSystem<S>::velocity_jacobian(const VectorX& y, const trajectory::DriveSample& target,
                                            MatrixX& jacobian) {
  const int count = tree_.closure_rows + drive_.row_count();
  VectorX residual = VectorX::Zero(count);
  jacobian.setZero(count, columns());
  compute_poses(tree_, y.data(), state_);
  const auto add = [&](int row, int column, double value) { jacobian(row, column) += value; };
  add_closures(residual, add);
  add_velocity_closures(add);
  add_drive(y, target, tree_.closure_rows, residual, add);
  for (int c = 0; c < columns(); ++c)
    if (tree_.is_length_column[c]) jacobian.col(c) *= tree_.characteristic_length;
}

template <class S>
void ConstraintSystem<S>::evaluate(const VectorX& y, const trajectory::DriveSample& target, VectorX& residual,
                                   numerics::SparseMatrix& jacobian) {
  residual.setZero(rows());
  compute_poses(tree_, y.data(), state_);
  entries_.clear();
  const auto add = [&](int row, int column, double value) {
    entries_.emplace_back(row, column, tree_.is_length_column[column] ? tree_.characteristic_length * value : value);
  };
  add_closures(residual, add);
  add_drive(y, target, tree_.position_rows, residual, add);
  jacobian.resize(rows(), columns());
  jacobian.setFromTriplets(entries_.begin(), entries_.end());
}

template <class S>
template <class Add>
void ConstraintSystem<S>::add_closures(VectorX& residual, const Add& add) {
  int r = 0;
  for (const Closure<S>& closure : tree_.closures) {
    if (closure.is_velocity_level()) break;
    const ClosurePose<S> pose = closure_pose(state_, closure);
    for (const ClosureRow& row : closure.rows) {
      const double scale = compute_row_scale(tree_, closure, row);
      const ConstraintWrench<S> wrench = closure_wrench(closure, pose, row);
      residual[r] = scale * closure_residual(pose, row);
      for (const PathStep& step : closure.path) {
        const Node<S>& node = tree_.nodes[step.node];
        add(r, node.column, scale * step.sign * wrench_power(node, state_[step.node], pose.p_B, wrench));
      }
      ++r;
    }
  }
}

template <class S>
template <class Add>
void ConstraintSystem<S>::add_velocity_closures(const Add& add) const {
  int r = tree_.position_rows;
  for (const Closure<S>& closure : tree_.closures) {
    if (!closure.is_velocity_level()) continue;
    const ClosurePose<S> pose = closure_pose(state_, closure);
    for (const ClosureRow& row : closure.rows) {
      const double scale = compute_row_scale(tree_, closure, row);
      for (const PathStep& step : closure.path)
        add(r, tree_.nodes[step.node].column,
            scale * velocity_row_coefficient(tree_, state_, closure, pose, row, step));
      ++r;
    }
  }
}

template <class S>
template <class Add>
void ConstraintSystem<S>::add_drive(const VectorX& y, const trajectory::DriveSample& target, int first_row,
                                    VectorX& residual, const Add& add) {
  const double scale = 1 / tree_.characteristic_length;
  int r = first_row, k = 0;
  if (!drive_.point.empty()) {
    const typename S::Vector Q = position(state_, drive_.tool);
    for (const int component : drive_.point) {
      residual[r] = scale * (Q[component] - target.value[k++]);
      ConstraintWrench<S> unit;
      unit.force[component] = 1;
      for (const int n : drive_.tool_path)
        add(r, tree_.nodes[n].column, scale * wrench_power(tree_.nodes[n], state_[n], Q, unit));
      ++r;
    }
  }
  if (!drive_.com.empty()) {
    masses_.update(tree_, state_);
    const typename S::Vector G = masses_.com();
    for (const int component : drive_.com) {
      residual[r] = scale * (G[component] - target.value[k++]);
      for (std::size_t n = 1; n < tree_.nodes.size(); ++n)
        if (tree_.nodes[n].motion != NodeMotion::weld)
          add(r, tree_.nodes[n].column,
              scale * masses_.com_gradient(tree_.nodes[n], state_[n], static_cast<int>(n))[component]);
      ++r;
    }
  }
  for (const LinearQuantity& quantity : drive_.linear) {
    const double unit = quantity.is_length ? scale : 1;
    residual[r] = unit * (quantity.value(y.data()) - target.value[k++]);
    for (const auto& [column, coefficient] : quantity.terms) add(r, column, unit * coefficient);
    ++r;
  }
  if (!drive_.rotation.empty()) {
    const Matrix3 R = to_matrix(orientation(state_, drive_.tool));
    const RotationResidual<double> rotation_residual(target.rotation, R);
    const QuaternionError error(target.rotation, R);
    const bool is_full_rotation = drive_.rotation.size() == 3;  // for single components only the sine is meaningful
    for (const int component : drive_.rotation) {
      residual[r] = is_full_rotation ? error.error[component] : rotation_residual.residual[component];
      const Vector3 gradient = (is_full_rotation ? error.jacobian : rotation_residual.jacobian).row(component);
      for (const int n : drive_.tool_path)
        if (tree_.nodes[n].motion == NodeMotion::revolute)
          add(r, tree_.nodes[n].column,
              tree_.nodes[n].ratio * gradient.dot(angular_to_3d(revolute_axis(state_[n].R_WN))));
      ++r;
    }
  }
}

template <class S>
bool ConstraintSystem<S>::is_aligned() const {
  for (const Closure<S>& closure : tree_.closures)
    if (!kinematics::is_aligned(closure_pose(state_, closure), closure)) return false;
  return true;
}

template <class S>
trajectory::DriveSample ConstraintSystem<S>::measure(const VectorX& y) const {
  return kinematics::measure_drive(tree_, drive_, state_, y.data());
}

template class ConstraintSystem<Planar>;
template class ConstraintSystem<Spatial>;

}  // namespace balance::kinematics
