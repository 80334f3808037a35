#include "jacobian_peer.hpp"

#include <algorithm>
#include <cmath>

namespace balance::peers {

JacobianPeer::JacobianPeer(const RigidTree& tree) : cut_joints_(tree.cut_joints) {
  Eigen::Index rows = 0;
  for (const CutJoint& cut : cut_joints_) rows += static_cast<Eigen::Index>(cut.equations.size());
  jacobian_.setZero(rows, tree.motion_count());
  for (FrameMotion* motion : {&a_, &b_}) {
    motion->point_jacobian.setZero(3, tree.motion_count());
    motion->rotation_jacobian.setZero(3, tree.motion_count());
  }
}

void JacobianPeer::place(const BodyFrame& frame, FrameMotion& motion) {
  motion.point = frame.point;
  motion.axes = frame.axes;
  if (frame.body == tree_ground) return;
  Matrix3 rotation;
  Vector3 origin;
  body_pose(frame.body, rotation, origin);
  motion.point = origin + rotation * frame.point;
  motion.axes = rotation * frame.axes;
}

const MatrixX& JacobianPeer::compute_closure_jacobian() {
  Eigen::Index row = 0;
  for (const CutJoint& cut : cut_joints_) {
    for (const auto& [frame, motion] : {std::pair(&cut.a, &a_), std::pair(&cut.b, &b_)}) {
      place(*frame, *motion);
      motion->point_jacobian.setZero();
      motion->rotation_jacobian.setZero();
      if (frame->body != tree_ground) frame_jacobian(frame->body, frame->point, motion->point, *motion);
    }
    for (const ClosureEquation& equation : cut.equations) {
      const Vector3 a = a_.axes.col(equation.i);
      if (equation.is_along)  // d/dt (a · d) = a · (v_b − v_a) + (ω_a × a) · d
        jacobian_.row(row) = a.transpose() * (b_.point_jacobian - a_.point_jacobian) +
                             a.cross(b_.point - a_.point).transpose() * a_.rotation_jacobian;
      else  // d/dt (a · b) = (ω_b − ω_a) · (b × a)
        jacobian_.row(row) =
            Vector3(b_.axes.col(equation.j)).cross(a).transpose() * (b_.rotation_jacobian - a_.rotation_jacobian);
      ++row;
    }
  }
  return jacobian_;
}

double JacobianPeer::closure_residual() {
  double largest = 0;
  for (const CutJoint& cut : cut_joints_) {
    place(cut.a, a_);
    place(cut.b, b_);
    for (const ClosureEquation& equation : cut.equations) {
      const double value = equation.is_along ? a_.axes.col(equation.i).dot(b_.point - a_.point)
                                             : a_.axes.col(equation.i).dot(b_.axes.col(equation.j));
      largest = std::max(largest, std::abs(value));
    }
  }
  return largest;
}

}  // namespace balance::peers
