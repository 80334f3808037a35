#include "balance/kinematics/system.hpp"

namespace balance {

template <class S>
System<S>::System(const Tree<S>& tree, Drive<S> drive)
    : tree_(tree), drive_(std::move(drive)), state_(tree.nodes.size()), masses_(tree) {}

template <class S>
void System<S>::evaluate(const VectorX& y, const DriveSample& target, VectorX& residual, MatrixX& jacobian) {
  residual.setZero(rows());
  jacobian.setZero(rows(), columns());
  poses(tree_, y.data(), state_);
  const auto add = [&](int row, int column, double value) { jacobian(row, column) += value; };
  closures(residual, add);
  prescribed(y, target, tree_.place_rows, residual, add);
  for (int c = 0; c < columns(); ++c)
    if (tree_.column_kind_length[c]) jacobian.col(c) *= tree_.length;
}

template <class S>
void System<S>::rates(const VectorX& y, const DriveSample& target, MatrixX& jacobian) {
  const int count = tree_.closure_rows + drive_.rows();
  VectorX residual = VectorX::Zero(count);
  jacobian.setZero(count, columns());
  poses(tree_, y.data(), state_);
  const auto add = [&](int row, int column, double value) { jacobian(row, column) += value; };
  closures(residual, add);
  bound_rates(add);
  prescribed(y, target, tree_.closure_rows, residual, add);
  for (int c = 0; c < columns(); ++c)
    if (tree_.column_kind_length[c]) jacobian.col(c) *= tree_.length;
}

template <class S>
void System<S>::evaluate(const VectorX& y, const DriveSample& target, VectorX& residual, SparseMatrix& jacobian) {
  residual.setZero(rows());
  poses(tree_, y.data(), state_);
  entries_.clear();
  const auto add = [&](int row, int column, double value) {
    entries_.emplace_back(row, column, tree_.column_kind_length[column] ? tree_.length * value : value);
  };
  closures(residual, add);
  prescribed(y, target, tree_.place_rows, residual, add);
  jacobian.resize(rows(), columns());
  jacobian.setFromTriplets(entries_.begin(), entries_.end());
}

template <class S>
template <class Add>
void System<S>::closures(VectorX& residual, const Add& add) {
  int r = 0;
  for (const Closure<S>& closure : tree_.closures) {
    if (closure.of_rates()) break;
    const ClosurePose<S> pose = closure_pose(state_, closure);
    for (const ClosureRow& row : closure.rows) {
      const double scale = row_unit(tree_, closure, row);
      const RowWrench<S> wrench = closure_wrench(closure, pose, row);
      residual[r] = scale * closure_residual(pose, row);
      for (const PathStep& step : closure.path) {
        const Node<S>& node = tree_.nodes[step.node];
        add(r, node.column, scale * step.sign * power_of(node, state_[step.node], pose.p_B, wrench));
      }
      ++r;
    }
  }
}

template <class S>
template <class Add>
void System<S>::bound_rates(const Add& add) const {
  int r = tree_.place_rows;
  for (const Closure<S>& closure : tree_.closures) {
    if (!closure.of_rates()) continue;
    const ClosurePose<S> pose = closure_pose(state_, closure);
    for (const ClosureRow& row : closure.rows) {
      const double scale = row_unit(tree_, closure, row);
      for (const PathStep& step : closure.path)
        add(r, tree_.nodes[step.node].column, scale * row_rate(tree_, state_, closure, pose, row, step));
      ++r;
    }
  }
}

template <class S>
template <class Add>
void System<S>::prescribed(const VectorX& y, const DriveSample& target, int first_row, VectorX& residual,
                           const Add& add) {
  const double scale = 1 / tree_.length;
  int r = first_row, k = 0;
  if (!drive_.point.empty()) {
    const typename S::Vector Q = position(state_, drive_.tool);
    for (const int component : drive_.point) {
      residual[r] = scale * (Q[component] - target.value[k++]);
      RowWrench<S> unit;
      unit.force[component] = 1;
      for (const int n : drive_.tool_path)
        add(r, tree_.nodes[n].column, scale * power_of(tree_.nodes[n], state_[n], Q, unit));
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
    const RotationGap<double> gap(target.rotation, R);
    const RotationError error(target.rotation, R);
    const bool whole = drive_.rotation.size() == 3;  // of single components only the sine has a meaning
    for (const int component : drive_.rotation) {
      residual[r] = whole ? error.error[component] : gap.gap[component];
      const Vector3 gradient = (whole ? error.B : gap.A).row(component);
      for (const int n : drive_.tool_path)
        if (tree_.nodes[n].motion == NodeMotion::turn)
          add(r, tree_.nodes[n].column, tree_.nodes[n].ratio * gradient.dot(angular_to_3d(turn_axis(state_[n].R_WN))));
      ++r;
    }
  }
}

template <class S>
bool System<S>::aligned() const {
  for (const Closure<S>& closure : tree_.closures)
    if (!is_aligned(closure_pose(state_, closure), closure)) return false;
  return true;
}

template <class S>
DriveSample System<S>::measure(const VectorX& y) const {
  return balance::measure(tree_, drive_, state_, y.data());
}

template class System<Planar>;
template class System<Spatial>;

}  // namespace balance
