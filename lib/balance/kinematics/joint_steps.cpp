#include "balance/kinematics/joint_steps.hpp"

#include "balance/base/number.hpp"
#include "balance/base/rotation.hpp"

#include <stdexcept>

namespace balance {

template <class T>
std::vector<Step<T>> steps(const JointOf<T>& joint) {
  using enum NodeMotion;
  using Vector = Vector3Of<T>;
  const Vector u = joint.axis, v = joint.axis2, z = Vector::UnitZ();
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{turn, u, 0}};
    case JointType::prismatic: return {{slide, u, 0}};
    case JointType::pin_slot: return {{slide, u, 0}, {turn, z, 1}};
    case JointType::cylindrical: return {{slide, u, 1}, {turn, u, 0}};
    case JointType::universal: return {{turn, u, 0}, {turn, v, 1}};
    case JointType::spherical: return {{turn, Vector::UnitX(), 0}, {turn, Vector::UnitY(), 1}, {turn, z, 2}};
    case JointType::planar: return {{slide, v, 0}, {slide, cross(u, v), 1}, {turn, u, 2}};
    case JointType::rolling_disc:
      return {{slide, v, 0}, {slide, cross(u, v), 1}, {turn, u, 2}, {turn, v, 3, joint.radius}, {turn, cross(u, v), 4}};
    case JointType::rolling_sphere:
      return {{slide, v, 0},
              {slide, cross(u, v), 1, joint.radius},
              {turn, Vector::UnitX(), 2},
              {turn, Vector::UnitY(), 3},
              {turn, z, 4}};
  }
  return {};
}

template <class S>
Matrix3Of<typename S::Scalar> node_axes(const Step<typename S::Scalar>& step) {
  using Matrix = Matrix3Of<typename S::Scalar>;
  if constexpr (is_planar<S>) {
    Matrix R = Matrix::Identity();
    if (step.motion == NodeMotion::turn) return R;
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
    return slides ? node_axes<S>({NodeMotion::slide, joint.axis, 0}) : Matrix(Matrix::Identity());
  } else {
    if (joint.type == JointType::spherical || joint.type == JointType::fixed) return Matrix::Identity();
    if (joint.type != JointType::universal && joint.type != JointType::planar && !rolls(joint.type))
      return frame_with_z_along(joint.axis);
    Matrix R;
    R << joint.axis2, cross(joint.axis, joint.axis2), joint.axis;
    return R;
  }
}

template <class S>
void set_rows(JointType type, Closure<S>& closure) {
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

template std::vector<Step<Number>> steps<Number>(const JointOf<Number>&);
template Matrix3Of<Number> node_axes<PlanarOf<Number>>(const Step<Number>&);
template Matrix3Of<Number> node_axes<SpatialOf<Number>>(const Step<Number>&);
template Matrix3Of<Number> closure_axes<PlanarOf<Number>>(const JointOf<Number>&);
template Matrix3Of<Number> closure_axes<SpatialOf<Number>>(const JointOf<Number>&);
template void set_rows<PlanarOf<Number>>(JointType, Closure<PlanarOf<Number>>&);
template void set_rows<SpatialOf<Number>>(JointType, Closure<SpatialOf<Number>>&);

}  // namespace balance
