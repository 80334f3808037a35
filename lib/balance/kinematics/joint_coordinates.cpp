#include "balance/kinematics/joint_coordinates.hpp"

#include "balance/base/rotation.hpp"

#include <cmath>
#include <numbers>

namespace balance {

template <class S>
RelativeMotion relative_motion(const Tree<S>& tree, const State<S>& state, const Joint& joint) {
  const FixedFrame<S>&first = tree.bodies[joint.first], &second = tree.bodies[joint.second];
  const NodeState<S>&A = state[first.node], &B = state[second.node];
  const typename S::Vector p_A = first.p_N + first.R_N * to_vector<S>(joint.point_first);
  const typename S::Vector p_B = second.p_N + second.R_N * to_vector<S>(joint.point_second);
  const Matrix3 R_WA = to_matrix(orientation(state, first));
  const Matrix3 R_AW = R_WA.transpose();
  const Vector3 d = to_3d(typename S::Vector(B.p_WN + B.R_WN * p_B - A.p_WN - A.R_WN * p_A));
  const Vector3 w_A = angular_to_3d(typename S::Angular(A.R_WN * A.angular_velocity));
  const Vector3 w = angular_to_3d(typename S::Angular(B.R_WN * B.angular_velocity)) - w_A;
  const Vector3 alpha_A = angular_to_3d(typename S::Angular(A.R_WN * A.angular_acceleration));
  const Vector3 alpha_B = angular_to_3d(typename S::Angular(B.R_WN * B.angular_acceleration));
  const Vector3 slip = to_3d(typename S::Vector(point_velocity<S>(B, p_B) - point_velocity<S>(A, p_A))) - w_A.cross(d);
  const Vector3 slip_rate = to_3d(typename S::Vector(point_acceleration<S>(B, p_B) - point_acceleration<S>(A, p_A))) -
                            alpha_A.cross(d) - w_A.cross(w_A.cross(d)) - 2 * w_A.cross(slip);
  RelativeMotion motion;
  motion.rotation = R_AW * to_matrix(orientation(state, second)) * joint.rotation.transpose();
  motion.place = R_AW * d;
  motion.slip = R_AW * slip;
  motion.slip_rate = R_AW * slip_rate;
  motion.spin = R_AW * w;
  motion.spin_rate = R_AW * (alpha_B - alpha_A - w_A.cross(w));
  return motion;
}

namespace {

void read_angle(int k, const Vector3& u, const RelativeMotion& motion, JointReading& reading) {
  const Matrix3& R = motion.rotation;
  const Vector3 twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  reading.position[k] = std::atan2(u.dot(twice_sine), R.trace() - 1);
  reading.velocity[k] = u.dot(motion.spin);
  reading.acceleration[k] = u.dot(motion.spin_rate);
}

void read_slide(int k, const Vector3& u, const RelativeMotion& motion, JointReading& reading) {
  reading.position[k] = u.dot(motion.place);
  reading.velocity[k] = u.dot(motion.slip);
  reading.acceleration[k] = u.dot(motion.slip_rate);
}

void read_universal(const Joint& joint, const RelativeMotion& motion, JointReading& reading) {
  const Vector3 u = joint.axis, v = joint.axis2, w = u.cross(v);
  const Vector3 turned_v = motion.rotation * v;  // the second rotation is about it
  reading.position[0] = std::atan2(w.dot(turned_v), v.dot(turned_v));
  reading.position[1] = std::atan2(u.dot(motion.rotation * w), u.dot(motion.rotation * u));
  reading.velocity = {u.dot(motion.spin), turned_v.dot(motion.spin), 0};
  reading.acceleration = {u.dot(motion.spin_rate), turned_v.dot(motion.spin_rate), 0};
}

void read_spherical(const RelativeMotion& motion, JointReading& reading) {
  const Matrix3& R = motion.rotation;
  const double a = std::atan2(-R(1, 2), R(2, 2)), b = std::atan2(R(0, 2), std::hypot(R(0, 0), R(0, 1)));
  reading.position = {a, b, std::atan2(-R(0, 1), R(0, 0))};
  const Vector3 x = Vector3::UnitX(), y(0, std::cos(a), std::sin(a)), z = R.col(2);
  Matrix3 axes;
  axes << x, y, z;
  const Matrix3 inverse = axes.inverse();
  const Vector3 rate = inverse * motion.spin;
  const Vector3 turning = rate[0] * rate[1] * x.cross(y) + rate[2] * (rate[0] * x + rate[1] * y).cross(z);
  const Vector3 acceleration = inverse * (motion.spin_rate - turning);
  for (int k = 0; k < 3; ++k) reading.velocity[k] = rate[k], reading.acceleration[k] = acceleration[k];
}

}  // namespace

JointReading read_joint(const Joint& joint, const RelativeMotion& motion) {
  JointReading reading;
  const Vector3& u = joint.axis;
  switch (joint.type) {
    case JointType::fixed: break;
    case JointType::revolute: read_angle(0, u, motion, reading); break;
    case JointType::prismatic: read_slide(0, u, motion, reading); break;
    case JointType::pin_slot:
      read_slide(0, u, motion, reading);
      read_angle(1, Vector3::UnitZ(), motion, reading);
      break;
    case JointType::cylindrical:
      read_angle(0, u, motion, reading);
      read_slide(1, u, motion, reading);
      break;
    case JointType::universal: read_universal(joint, motion, reading); break;
    case JointType::spherical: read_spherical(motion, reading); break;
    case JointType::planar:
      read_slide(0, joint.axis2, motion, reading);
      read_slide(1, u.cross(joint.axis2), motion, reading);
      read_angle(2, u, motion, reading);
      break;
  }
  return reading;
}

double unwrapped(double angle, double reference) {
  constexpr double turn = 2 * std::numbers::pi;
  return angle + turn * std::round((reference - angle) / turn);
}

template <class S>
std::vector<double> read_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  State<S> state(tree.nodes.size());
  poses(tree, y.data(), state);
  std::vector<double> values;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const CoordinateSource& source = tree.sources[c];
    const Joint& joint = mechanism.joints[coordinate.joint];
    const double value = source.column >= 0 && !tree.joint_floats[coordinate.joint]
                             ? source.ratio * y[source.column] + source.offset
                             : read_joint(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    values.push_back(coordinate.kind == CoordinateKind::angle ? unwrapped(value, 0) : value);
  }
  return values;
}

template std::vector<double> read_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
template std::vector<double> read_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&, const VectorX&);
template RelativeMotion relative_motion<Planar>(const Tree<Planar>&, const State<Planar>&, const Joint&);
template RelativeMotion relative_motion<Spatial>(const Tree<Spatial>&, const State<Spatial>&, const Joint&);

}  // namespace balance
