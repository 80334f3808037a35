#pragma once
/// The algebra of space: angular quantities are vectors, rotations matrices. Private to the rooms of kinematics, motion and dynamics.

#include "balance/base/types.hpp"

namespace balance {

template <class T>
struct SpatialRotation {
  Matrix3Of<T> matrix = Matrix3Of<T>::Identity();
};

/// The same in other numbers.
template <class To, class From>
SpatialRotation<To> cast(const SpatialRotation<From>& R) {
  return {R.matrix.template cast<To>()};
}

template <class T>
struct SpatialOf {
  static constexpr int dimension = 3;
  static constexpr int angular_dimension = 3;
  static constexpr int inertial_parameter_count = 10;  ///< m, mx, my, mz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz
  using Scalar = T;
  using Constants = SpatialOf<ModelScalarOf<T>>;
  using Vector = Vector3Of<T>;
  using Angular = Vector3Of<T>;
  using Rotation = SpatialRotation<T>;
  using AccelerationOperator =
      Matrix3Of<T>;  ///< what the velocity and acceleration of a frame do to a vector fixed to it

  struct Inertia {
    T mass = 0;
    Vector first_moment = Vector::Zero();
    Matrix3Of<T> second_moment = Matrix3Of<T>::Zero();
  };

  static Vector slide_direction() { return Vector::UnitZ(); }
  static Vector zero_angular() { return Vector::Zero(); }
  static AccelerationOperator zero_acceleration_operator() { return AccelerationOperator::Zero(); }
};

template <class A, class B>
inline Vector3Of<ProductOf<A, B>> cross(const Vector3Of<A>& a, const Vector3Of<B>& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}
template <class T>
inline T dot(const Vector3Of<T>& a, const Vector3Of<T>& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}
template <class T>
inline T dot(const Vector2Of<T>& a, const Vector2Of<T>& b) {
  return a.x() * b.x() + a.y() * b.y();
}
template <class T>
inline Vector3Of<T> revolute_axis(const SpatialRotation<T>& R) {
  return R.matrix.col(2);
}
/// M v, written out: for three rows the general product spends more on its loop than on its arithmetic.
template <class A, class B>
inline Vector3Of<ProductOf<A, B>> times(const Matrix3Of<A>& M, const Vector3Of<B>& v) {
  const B x = v.x(), y = v.y(), z = v.z();
  return {M(0, 0) * x + M(0, 1) * y + M(0, 2) * z, M(1, 0) * x + M(1, 1) * y + M(1, 2) * z,
          M(2, 0) * x + M(2, 1) * y + M(2, 2) * z};
}
template <class A, class B>
inline Vector3Of<ProductOf<A, B>> operator*(const SpatialRotation<A>& R, const Vector3Of<B>& v) {
  return times(R.matrix, v);
}
template <class T>
inline Vector3Of<T> rotate_inverse(const SpatialRotation<T>& R, const Vector3Of<T>& v) {
  const Matrix3Of<T>& M = R.matrix;
  const T x = v.x(), y = v.y(), z = v.z();
  return {M(0, 0) * x + M(1, 0) * y + M(2, 0) * z, M(0, 1) * x + M(1, 1) * y + M(2, 1) * z,
          M(0, 2) * x + M(1, 2) * y + M(2, 2) * z};
}
template <class A, class B>
inline SpatialRotation<ProductOf<A, B>> operator*(const SpatialRotation<A>& a, const SpatialRotation<B>& b) {
  return {Matrix3Of<ProductOf<A, B>>(a.matrix * b.matrix)};
}
template <class T>
inline SpatialRotation<T> rotate_about_joint_axis(const SpatialRotation<ModelScalarOf<T>>& R, const T& c, const T& s) {
  SpatialRotation<T> out;
  out.matrix.col(0) = c * R.matrix.col(0) + s * R.matrix.col(1);
  out.matrix.col(1) = c * R.matrix.col(1) - s * R.matrix.col(0);
  out.matrix.col(2) = R.matrix.col(2).template cast<T>();
  return out;
}
template <class T>
inline Vector3Of<T> axis(const SpatialRotation<T>& R, int k) {
  return R.matrix.col(k);
}
/// ω × Jω.
template <class T>
inline Vector3Of<T> gyroscopic(const Vector3Of<T>& w, const Matrix3Of<ModelScalarOf<T>>& J) {
  return cross(w, times(J, w));
}

template <class T>
inline Matrix3Of<T> make_acceleration_operator(const Vector3Of<T>& w, const Vector3Of<T>& alpha) {
  const T xx = w.x() * w.x(), yy = w.y() * w.y(), zz = w.z() * w.z();
  const T xy = w.x() * w.y(), xz = w.x() * w.z(), yz = w.y() * w.z();
  Matrix3Of<T> K;
  K << -yy - zz, xy - alpha.z(), xz + alpha.y(), xy + alpha.z(), -xx - zz, yz - alpha.x(), xz - alpha.y(),
      yz + alpha.x(), -xx - yy;
  return K;
}
template <class T>
inline void add_to_axis_component(Vector3Of<T>& w, const T& rate) {
  w.z() += rate;
}
template <class T>
inline Vector3Of<T> cross_with_axis(const Vector3Of<T>& w, const T& rate) {
  return {w.y() * rate, -w.x() * rate, T(0)};
}
template <class T>
inline T axis_component(const Vector3Of<T>& moment) {
  return moment.z();
}
template <class T>
inline T slide_component(const Vector3Of<T>& v) {
  return v.z();
}
template <class T>
inline void add_to_slide_component(Vector3Of<T>& v, const T& rate) {
  v.z() += rate;
}
template <class T>
inline Vector3Of<T> prismatic_axis(const SpatialRotation<T>& R) {
  return R.matrix.col(2);
}

}  // namespace balance
