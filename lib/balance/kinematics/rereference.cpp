#include "balance/base/elementary.hpp"
#include "balance/kinematics/tree.hpp"

#include <cmath>

namespace balance {

template <class S>
void reset_spherical_reference(Tree<S>& tree, NodeId spherical, typename S::Scalar* y) {
  Matrix3 all = Matrix3::Identity(), fixed = Matrix3::Identity();
  for (int n = spherical; n < spherical + 3; ++n) {
    const Node<S>& node = tree.nodes[n];
    const bool turns = node.motion == NodeMotion::revolute;  // the last of a held spin does not
    const double x = turns ? node.ratio * y[node.column] + node.offset : 0;
    all *= to_matrix(rotate_about_joint_axis(node.R_PF, elementary::cos(x), elementary::sin(x)));
    if (n > spherical) fixed *= to_matrix(node.R_PF);
    if (turns) y[node.column] = -node.offset / node.ratio;
  }
  // products of rotations drift; the nearest rotation does not
  const Eigen::Quaterniond exact = Eigen::Quaterniond(Matrix3(all * fixed.transpose())).normalized();
  tree.nodes[spherical].R_PF = to_rotation<S>(exact.toRotationMatrix());
}

template void reset_spherical_reference<Planar>(Tree<Planar>&, NodeId, double*);
template void reset_spherical_reference<Spatial>(Tree<Spatial>&, NodeId, double*);

}  // namespace balance
