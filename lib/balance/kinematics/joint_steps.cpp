#include "balance/kinematics/joint_steps.hpp"

#include "balance/base/number.hpp"
#include "balance/base/rotation.hpp"

#include <stdexcept>

namespace balance {

template <class T>
std::vector<ElementaryMotion<T>> list_elementary_motions(const JointOf<T>& joint) {
  using enum NodeMotion;
  using Vector = Vector3Of<T>;
  const Vector u = joint.axis, v = joint.axis2, z = Vector::UnitZ();
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{revolute, u, 0}};
    case JointType::prismatic: return {{prismatic, u, 0}};
    case JointType::pin_slot: return {{prismatic, u, 0}, {revolute, z, 1}};
    case JointType::cylindrical: return {{prismatic, u, 1}, {revolute, u, 0}};
    case JointType::universal: return {{revolute, u, 0}, {revolute, v, 1}};
    case JointType::spherical:
      return {{revolute, Vector::UnitX(), 0}, {revolute, Vector::UnitY(), 1}, {revolute, z, 2}};
    case JointType::planar: return {{prismatic, v, 0}, {prismatic, cross(u, v), 1}, {revolute, u, 2}};
    case JointType::rolling_disc:
      return {{prismatic, v, 0},
              {prismatic, cross(u, v), 1},
              {revolute, u, 2},
              {revolute, v, 3, joint.radius},
              {revolute, cross(u, v), 4}};
    case JointType::rolling_sphere:
      return {{prismatic, v, 0},
              {prismatic, cross(u, v), 1, joint.radius},
              {revolute, Vector::UnitX(), 2},
              {revolute, Vector::UnitY(), 3},
              {revolute, z, 4}};
  }
  return {};
}

template <class S>
Matrix3Of<typename S::Scalar> node_axes(const ElementaryMotion<typename S::Scalar>& step) {
  using Matrix = Matrix3Of<typename S::Scalar>;
  if constexpr (is_planar<S>) {
    Matrix R = Matrix::Identity();
    if (step.motion == NodeMotion::revolute) return R;
    const auto& d = step.direction;
    R.template topLeftCorner<2, 2>() << d.x(), -d.y(), d.y(), d.x();
    return R;
  } else {
    return frame_with_z_along(step.direction);
  }
}

template <class S>
Matrix3Of<typename S::Scalar> closure_axes(const JointOf<typename S::Scalar>& joint) {
  using Matrix = Matrix3Of<typename S::Scalar>;
  if constexpr (is_planar<S>) {
    const bool slides = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
    return slides ? node_axes<S>({NodeMotion::prismatic, joint.axis, 0}) : Matrix(Matrix::Identity());
  } else {
    if (joint.type == JointType::spherical || joint.type == JointType::fixed) return Matrix::Identity();
    if (joint.type != JointType::universal && joint.type != JointType::planar && !is_rolling(joint.type))
      return frame_with_z_along(joint.axis);
    Matrix R;
    R << joint.axis2, cross(joint.axis, joint.axis2), joint.axis;
    return R;
  }
}

template <class S>
void set_closure_rows(JointType type, Closure<S>& closure) {
  using enum ClosureRow::Kind;
  const ClosureRow x{along, 0, 0}, y{along, 1, 0}, z{along, 2, 0};
  if constexpr (is_planar<S>) {
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

template std::vector<ElementaryMotion<EngineScalar>> list_elementary_motions<EngineScalar>(
    const JointOf<EngineScalar>&);
template Matrix3Of<EngineScalar> node_axes<PlanarOf<EngineScalar>>(const ElementaryMotion<EngineScalar>&);
template Matrix3Of<EngineScalar> node_axes<SpatialOf<EngineScalar>>(const ElementaryMotion<EngineScalar>&);
template Matrix3Of<EngineScalar> closure_axes<PlanarOf<EngineScalar>>(const JointOf<EngineScalar>&);
template Matrix3Of<EngineScalar> closure_axes<SpatialOf<EngineScalar>>(const JointOf<EngineScalar>&);
template void set_closure_rows<PlanarOf<EngineScalar>>(JointType, Closure<PlanarOf<EngineScalar>>&);
template void set_closure_rows<SpatialOf<EngineScalar>>(JointType, Closure<SpatialOf<EngineScalar>>&);

}  // namespace balance
