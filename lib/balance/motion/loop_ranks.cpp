#include "balance/motion/loop_ranks.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/kinematics/closure.hpp"

namespace balance {

namespace {

constexpr std::size_t max_loops = 64;

template <class S>
using LoopTwist = Eigen::Matrix<double, S::dimension + S::angular_dimension, 1>;

void put_angular(LoopTwist<Planar>& twist, double value) { twist[2] = value; }
void put_angular(LoopTwist<Spatial>& twist, const Vector3& value) { twist.tail<3>() = value; }

/// Per unit rate of a node's coordinate (per characteristic length, if that is a length): velocity at a point in characteristic lengths,
/// angular velocity.
template <class S>
LoopTwist<S> twist_of(const Tree<S>& tree, int n, const TreeState<S>& poses, const typename S::Vector& about) {
  const Node<S>& node = tree.nodes[n];
  const double scale = tree.is_length_column[node.column] != 0 ? tree.characteristic_length : 1;
  LoopTwist<S> twist = LoopTwist<S>::Zero();
  twist.template head<S::dimension>() = scale / tree.characteristic_length * partial_velocity(node, poses[n], about);
  if (node.motion == NodeMotion::revolute)
    put_angular(twist, typename S::Angular(scale * node.ratio * revolute_axis(poses[n].R_WN)));
  return twist;
}

/// What a closure leaves free of the motion of b against a: whatever its wrenches do no work on.
template <class S>
MatrixX find_free_twists(const Tree<S>& tree, const Closure<S>& closure, const TreeState<S>& poses,
                         const typename S::Vector& about) {
  const ClosurePose<S> pose = closure_pose(poses, closure);
  const auto rows = static_cast<Eigen::Index>(closure.rows.size());
  MatrixX wrenches(rows, S::dimension + S::angular_dimension);
  const typename S::Vector arm = (pose.p_B - about) / tree.characteristic_length;
  for (Eigen::Index r = 0; r < rows; ++r) {
    const ConstraintWrench<S> wrench = closure_wrench(closure, pose, closure.rows[static_cast<std::size_t>(r)]);
    LoopTwist<S> row = LoopTwist<S>::Zero();
    row.template head<S::dimension>() = wrench.force;
    put_angular(row, typename S::Angular(wrench.moment + cross(arm, wrench.force)));
    wrenches.row(r) = row;
  }
  const SingularValueDecomposition svd(wrenches, Eigen::ComputeFullV);
  return svd.matrixV().rightCols(wrenches.cols() - rows);
}

}  // namespace

template <class S>
LoopRankMonitor<S>::LoopRankMonitor(const Mechanism& mechanism, const Tree<S>& tree)
    : mechanism_(mechanism), tree_(tree), loops_(list_simple_loops(mechanism, max_loops)) {}

template <class S>
std::string LoopRankMonitor<S>::joint_names(std::size_t loop) const {
  std::string names;
  for (const LoopStep& step : loops_[loop])
    names += (names.empty() ? "" : ", ") + mechanism_.joints[static_cast<std::size_t>(step.joint)].name;
  return names;
}

/// Adds what the joint's own coordinates do to the columns of the tree, or columns for a cut joint.
template <class S>
void LoopRankMonitor<S>::add_joint_twists(const LoopStep& step, const TreeState<S>& poses,
                                          const typename S::Vector& about, MatrixX& twists) const {
  const auto joint = static_cast<std::size_t>(step.joint);
  const int last = tree_.joint_nodes[joint];
  if (last < 0) {
    for (const Closure<S>& closure : tree_.closures) {
      if (closure.joint != step.joint || closure.split || closure.is_velocity_level()) continue;
      const MatrixX left = find_free_twists(tree_, closure, poses, about);
      twists.conservativeResize(Eigen::NoChange, twists.cols() + left.cols());
      twists.rightCols(left.cols()) = left;
    }
    return;
  }
  const bool tree_forward = tree_.joint_forward[joint];
  const double sign = step.forward == tree_forward ? 1 : -1;
  const Joint& walked = mechanism_.joints[joint];
  const int first = tree_.bodies[static_cast<std::size_t>(tree_forward ? walked.first : walked.second)].node;
  for (int n = last; n != first && n > 0; n = tree_.nodes[n].parent)
    if (tree_.nodes[n].motion != NodeMotion::weld)
      twists.col(tree_.nodes[n].column) += sign * twist_of(tree_, n, poses, about);
}

template <class S>
VectorX LoopRankMonitor<S>::singular_values(std::size_t loop, const TreeState<S>& poses) const {
  const Joint& start = mechanism_.joints[static_cast<std::size_t>(loops_[loop].front().joint)];
  const FixedFrame<S>& frame = tree_.bodies[static_cast<std::size_t>(start.first)];
  const typename S::Vector about =
      poses[frame.node].p_WN +
      poses[frame.node].R_WN * typename S::Vector(frame.p_N + frame.R_N * to_vector<S>(start.point_first));
  MatrixX twists = MatrixX::Zero(S::dimension + S::angular_dimension, tree_.columns);
  for (const LoopStep& step : loops_[loop]) add_joint_twists(step, poses, about, twists);
  return balance::singular_values(twists);
}

template class LoopRankMonitor<Planar>;
template class LoopRankMonitor<Spatial>;

}  // namespace balance
