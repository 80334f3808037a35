#include "balance/kinematics/joint_steps.hpp"

#include "balance/base/rotation.hpp"

#include <stdexcept>
#include <type_traits>

namespace balance {

std::vector<Step> steps(const Joint& joint) {
  using enum NodeMotion;
  const Vector3 u = joint.axis, v = joint.axis2, z = Vector3::UnitZ();
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{turn, u, 0}};
    case JointType::prismatic: return {{slide, u, 0}};
    case JointType::pin_slot: return {{slide, u, 0}, {turn, z, 1}};
    case JointType::cylindrical: return {{slide, u, 1}, {turn, u, 0}};
    case JointType::universal: return {{turn, u, 0}, {turn, v, 1}};
    case JointType::spherical: return {{turn, Vector3::UnitX(), 0}, {turn, Vector3::UnitY(), 1}, {turn, z, 2}};
    case JointType::planar: return {{slide, v, 0}, {slide, u.cross(v), 1}, {turn, u, 2}};
  }
  return {};
}

template <>
Matrix3 node_axes<Spatial>(const Step& step) {
  return frame_with_z_along(step.direction);
}
template <>
Matrix3 node_axes<Planar>(const Step& step) {
  if (step.motion == NodeMotion::turn) return Matrix3::Identity();
  Matrix3 R = Matrix3::Identity();
  const Vector3& d = step.direction;
  R.topLeftCorner<2, 2>() << d.x(), -d.y(), d.y(), d.x();
  return R;
}

template <class S>
Matrix3 closure_axes(const Joint& joint) {
  if constexpr (std::is_same_v<S, Planar>) {
    const bool slides = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
    return slides ? node_axes<Planar>({NodeMotion::slide, joint.axis, 0}) : Matrix3::Identity();
  } else {
    if (joint.type == JointType::spherical || joint.type == JointType::fixed) return Matrix3::Identity();
    if (joint.type != JointType::universal && joint.type != JointType::planar) return frame_with_z_along(joint.axis);
    Matrix3 R;
    R << joint.axis2, joint.axis.cross(joint.axis2), joint.axis;
    return R;
  }
}

template <class S>
void set_rows(JointType type, Closure<S>& closure) {
  using enum ClosureRow::Kind;
  const ClosureRow x{along, 0, 0}, y{along, 1, 0}, z{along, 2, 0};
  if constexpr (std::is_same_v<S, Planar>) {
    const ClosureRow angle{dot, 1, 0};
    switch (type) {
      case JointType::revolute: closure.rows = {x, y}; break;
      case JointType::prismatic: closure.rows = {y, angle}, closure.aligned = {0}; break;
      case JointType::pin_slot: closure.rows = {y}; break;
      case JointType::fixed: closure.rows = {x, y, angle}, closure.aligned = {0}; break;
      default: throw std::invalid_argument("joint type does not exist in the plane");
    }
  } else {
    const ClosureRow xz{dot, 0, 2}, yz{dot, 1, 2}, zx{dot, 2, 0}, xy{dot, 0, 1};
    switch (type) {
      case JointType::revolute: closure.rows = {x, y, z, xz, yz}, closure.aligned = {2}; break;
      case JointType::prismatic: closure.rows = {x, y, yz, zx, xy}, closure.aligned = {0, 2}; break;
      case JointType::fixed: closure.rows = {x, y, z, yz, zx, xy}, closure.aligned = {0, 2}; break;
      case JointType::cylindrical: closure.rows = {x, y, xz, yz}, closure.aligned = {2}; break;
      case JointType::universal: closure.rows = {x, y, z, zx}; break;
      case JointType::spherical: closure.rows = {x, y, z}; break;
      case JointType::planar: closure.rows = {z, xz, yz}, closure.aligned = {2}; break;
      default: throw std::invalid_argument("joint type does not exist in space");
    }
  }
}

template Matrix3 closure_axes<Planar>(const Joint&);
template Matrix3 closure_axes<Spatial>(const Joint&);
template void set_rows<Planar>(JointType, Closure<Planar>&);
template void set_rows<Spatial>(JointType, Closure<Spatial>&);

}  // namespace balance
