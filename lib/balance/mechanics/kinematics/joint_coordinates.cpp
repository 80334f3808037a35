#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"

#include <cmath>

namespace balance::kinematics {

template <class S>
RelativeMotion<typename S::Scalar> relative_motion(const Tree<S>& tree, const TreeState<S>& state,
                                                   const model::JointOf<typename S::Scalar>& joint) {
  using Vector = Vector3Of<typename S::Scalar>;
  using Matrix = Matrix3Of<typename S::Scalar>;
  const FixedFrame<S>&first = tree.bodies[joint.first], &second = tree.bodies[joint.second];
  const NodeState<S>&A = state[first.node], &B = state[second.node];
  const typename S::Vector p_A = first.p_N + first.R_N * to_vector<S>(joint.point_first);
  const typename S::Vector p_B = second.p_N + second.R_N * to_vector<S>(joint.point_second);
  const Matrix R_WA = to_matrix(orientation(state, first));
  const Matrix R_AW = R_WA.transpose();
  const Vector d = to_3d(typename S::Vector(B.p_WN + B.R_WN * p_B - A.p_WN - A.R_WN * p_A));
  const Vector w_A = angular_to_3d(typename S::Angular(A.R_WN * A.angular_velocity));
  const Vector w = angular_to_3d(typename S::Angular(B.R_WN * B.angular_velocity)) - w_A;
  const Vector alpha_A = angular_to_3d(typename S::Angular(A.R_WN * A.angular_acceleration));
  const Vector alpha_B = angular_to_3d(typename S::Angular(B.R_WN * B.angular_acceleration));
  const Vector slip = to_3d(typename S::Vector(point_velocity<S>(B, p_B) - point_velocity<S>(A, p_A))) - w_A.cross(d);
  const Vector slip_rate = to_3d(typename S::Vector(point_acceleration<S>(B, p_B) - point_acceleration<S>(A, p_A))) -
                           alpha_A.cross(d) - w_A.cross(w_A.cross(d)) - 2 * w_A.cross(slip);
  RelativeMotion<typename S::Scalar> motion;
  motion.rotation = R_AW * to_matrix(orientation(state, second)) * joint.rotation.transpose();
  motion.displacement = R_AW * d;
  motion.linear_velocity = R_AW * slip;
  motion.linear_acceleration = R_AW * slip_rate;
  motion.angular_velocity = R_AW * w;
  motion.angular_acceleration = R_AW * (alpha_B - alpha_A - w_A.cross(w));
  return motion;
}

namespace {

using elementary::atan2, elementary::cos, elementary::sin;
using std::hypot;

template <class T>
void read_angle(int k, const Vector3Of<T>& u, const RelativeMotion<T>& motion, JointMotion<T>& joint_motion) {
  const Matrix3Of<T>& R = motion.rotation;
  const Vector3Of<T> twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  joint_motion.position[k] = atan2(u.dot(twice_sine), R.trace() - 1);
  joint_motion.velocity[k] = u.dot(motion.angular_velocity);
  joint_motion.acceleration[k] = u.dot(motion.angular_acceleration);
}

template <class T>
void read_slide(int k, const Vector3Of<T>& u, const RelativeMotion<T>& motion, JointMotion<T>& joint_motion) {
  joint_motion.position[k] = u.dot(motion.displacement);
  joint_motion.velocity[k] = u.dot(motion.linear_velocity);
  joint_motion.acceleration[k] = u.dot(motion.linear_acceleration);
}

template <class T>
void read_universal(const model::JointOf<T>& joint, const RelativeMotion<T>& motion, JointMotion<T>& joint_motion) {
  const Vector3Of<T> u = joint.axis, v = joint.axis2, w = u.cross(v);
  const Vector3Of<T> second_axis = motion.rotation * v;  // the second rotation is about it
  joint_motion.position[0] = atan2(w.dot(second_axis), v.dot(second_axis));
  joint_motion.position[1] = atan2(u.dot(motion.rotation * w), u.dot(motion.rotation * u));
  joint_motion.velocity = {u.dot(motion.angular_velocity), second_axis.dot(motion.angular_velocity)};
  joint_motion.acceleration = {u.dot(motion.angular_acceleration), second_axis.dot(motion.angular_acceleration)};
}

/// @param first index of the first of the three angles
template <class T>
void read_spherical(int first, const RelativeMotion<T>& motion, JointMotion<T>& joint_motion) {
  const Matrix3Of<T>& R = motion.rotation;
  const T a = atan2(-R(1, 2), R(2, 2)), b = atan2(R(0, 2), hypot(R(0, 0), R(0, 1)));
  const std::array<T, 3> angles{a, b, T(atan2(-R(0, 1), R(0, 0)))};
  const Vector3Of<T> x = Vector3Of<T>::UnitX(), y(T(0), cos(a), sin(a)), z = R.col(2);
  Matrix3Of<T> axes;
  axes << x, y, z;
  const Matrix3Of<T> inverse = axes.inverse();
  const Vector3Of<T> rate = inverse * motion.angular_velocity;
  const Vector3Of<T> bias = rate[0] * rate[1] * x.cross(y) + rate[2] * (rate[0] * x + rate[1] * y).cross(z);
  const Vector3Of<T> acceleration = inverse * (motion.angular_acceleration - bias);
  for (int k = 0; k < 3; ++k) {
    joint_motion.position[first + k] = angles[k];
    joint_motion.velocity[first + k] = rate[k];
    joint_motion.acceleration[first + k] = acceleration[k];
  }
}

/// Decomposes a disc's rotation into heading, lean and rolling angle. The position is that of the contact point.
template <class T>
void read_disc(const model::JointOf<T>& joint, const RelativeMotion<T>& motion, JointMotion<T>& joint_motion) {
  const Vector3Of<T> u = joint.axis, v = joint.axis2, w = u.cross(v);
  Matrix3Of<T> axes;
  axes << v, w, u;
  const Matrix3Of<T> R = axes.transpose() * motion.rotation * axes;  // Rz(heading) Rx(lean) Ry(angle)
  const T heading = atan2(-R(0, 1), R(1, 1)), lean = atan2(R(2, 1), hypot(R(0, 1), R(1, 1)));
  const T c = cos(heading), s = sin(heading), cl = cos(lean), sl = sin(lean);
  const Vector3Of<T> z = Vector3Of<T>::UnitZ(), x(c, s, T(0)), y(-s * cl, c * cl, sl);
  Matrix3Of<T> rotation_axes;
  rotation_axes << z, x, y;
  const Matrix3Of<T> inverse = rotation_axes.inverse();
  const Vector3Of<T> rate = inverse * (axes.transpose() * motion.angular_velocity);
  const Vector3Of<T> bias = rate[0] * rate[1] * z.cross(x) + rate[2] * (rate[0] * z + rate[1] * x).cross(y);
  const Vector3Of<T> acceleration = inverse * (axes.transpose() * motion.angular_acceleration - bias);
  // in the disc's plane, from the contact point to the centre
  const Vector3Of<T> up(s * sl, -c * sl, cl);
  const Vector3Of<T> w_up = rate[0] * z + rate[1] * x,
                     a_up = acceleration[0] * z + acceleration[1] * x + rate[0] * rate[1] * z.cross(x);
  const Vector3Of<T> up_rate = w_up.cross(up);
  const Vector3Of<T> contact_point = axes.transpose() * motion.displacement - joint.radius * up;
  const Vector3Of<T> slip = axes.transpose() * motion.linear_velocity - joint.radius * up_rate;
  const Vector3Of<T> slip_rate =
      axes.transpose() * motion.linear_acceleration - joint.radius * (a_up.cross(up) + w_up.cross(up_rate));
  joint_motion.position = {contact_point.x(), contact_point.y(), heading, lean, T(atan2(-R(2, 0), R(2, 2)))};
  joint_motion.velocity = {slip.x(), slip.y(), rate[0], rate[1], rate[2]};
  joint_motion.acceleration = {slip_rate.x(), slip_rate.y(), acceleration[0], acceleration[1], acceleration[2]};
}

}  // namespace

template <class T>
JointMotion<T> compute_joint_motion(const model::JointOf<T>& joint, const RelativeMotion<T>& motion) {
  JointMotion<T> joint_motion;
  const Vector3Of<T>& u = joint.axis;
  switch (joint.type) {
    case JointType::fixed: break;
    case JointType::revolute: read_angle(0, u, motion, joint_motion); break;
    case JointType::prismatic: read_slide(0, u, motion, joint_motion); break;
    case JointType::pin_slot:
      read_slide(0, u, motion, joint_motion);
      read_angle(1, Vector3Of<T>(Vector3Of<T>::UnitZ()), motion, joint_motion);
      break;
    case JointType::cylindrical:
      read_angle(0, u, motion, joint_motion);
      read_slide(1, u, motion, joint_motion);
      break;
    case JointType::universal: read_universal(joint, motion, joint_motion); break;
    case JointType::spherical: read_spherical(0, motion, joint_motion); break;
    case JointType::planar:
      read_slide(0, joint.axis2, motion, joint_motion);
      read_slide(1, u.cross(joint.axis2), motion, joint_motion);
      read_angle(2, u, motion, joint_motion);
      break;
    case JointType::free:
      for (int k = 0; k < 3; ++k) read_slide(k, Vector3Of<T>(Vector3Of<T>::Unit(k)), motion, joint_motion);
      read_spherical(3, motion, joint_motion);
      break;
    case JointType::rolling_disc: read_disc(joint, motion, joint_motion); break;
    case JointType::rolling_sphere:
      read_slide(0, joint.axis2, motion, joint_motion);
      read_slide(1, u.cross(joint.axis2), motion, joint_motion);
      read_spherical(2, motion, joint_motion);
      break;
  }
  return joint_motion;
}

template JointMotion<EngineScalar> compute_joint_motion<EngineScalar>(const model::JointOf<EngineScalar>&,
                                                                      const RelativeMotion<EngineScalar>&);
template RelativeMotion<EngineScalar> relative_motion<PlanarOf<EngineScalar>>(const Tree<PlanarOf<EngineScalar>>&,
                                                                              const TreeState<PlanarOf<EngineScalar>>&,
                                                                              const model::JointOf<EngineScalar>&);
template RelativeMotion<EngineScalar> relative_motion<SpatialOf<EngineScalar>>(
    const Tree<SpatialOf<EngineScalar>>&, const TreeState<SpatialOf<EngineScalar>>&,
    const model::JointOf<EngineScalar>&);

}  // namespace balance::kinematics
