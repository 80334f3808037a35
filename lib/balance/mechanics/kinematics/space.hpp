#pragma once
/// The algebra underlying the recursions, for the plane and for space, each over any scalar type T. A space has vectors
/// (positions, forces), angular quantities (scalars in the plane, vectors in space), rotations and inertias.

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <type_traits>

namespace balance::kinematics {

// The algebra of the plane: angular quantities are scalars, rotations unit complex numbers.

/// Unit complex number.
template <class T>
struct PlanarRotation {
  T c = 1, s = 0;
};

/// Maps a vector fixed to a rotating frame to its second derivative: v ↦ α × v + ω × (ω × v).
template <class T>
struct PlanarAccelerationOperator {
  T alpha, square;
};

/// Conversion to another scalar type.
template <class To, class From>
PlanarRotation<To> cast(const PlanarRotation<From>& R) {
  return {To(R.c), To(R.s)};
}

template <class T>
struct PlanarOf {
  static constexpr int dimension = 2;                 ///< components of a vector
  static constexpr int angular_dimension = 1;         ///< components of an angular quantity
  static constexpr int inertial_parameter_count = 4;  ///< inertial parameters of a body: m, mx, my, J
  using Scalar = T;
  using Constants = PlanarOf<ModelScalarOf<T>>;
  using Vector = Vector2Of<T>;
  using Angular = T;
  using Rotation = PlanarRotation<T>;
  using AccelerationOperator = PlanarAccelerationOperator<T>;

  /// About the origin of the frame in which it is expressed.
  struct Inertia {
    T mass = 0;
    Vector first_moment = Vector::Zero();  ///< first moment of mass
    T second_moment = 0;                   ///< moment of inertia about the origin
  };

  static Vector slide_direction() { return Vector::UnitX(); }
  static T zero_angular() { return 0; }
  static AccelerationOperator zero_acceleration_operator() { return {0, 0}; }
};

/// Scalar types, as opposed to vectors.
template <class T>
concept IsScalar = !requires {
  T::SizeAtCompileTime;
};

template <IsScalar T, class C>
inline Vector2Of<ProductOf<T, C>> cross(const T& w, const Vector2Of<C>& r) {
  return {-w * r.y(), w * r.x()};
}
template <class A, class B>
inline ProductOf<A, B> cross(const Vector2Of<A>& r, const Vector2Of<B>& f) {
  return r.x() * f.y() - r.y() * f.x();
}
template <IsScalar T>
inline T cross(const T&, const T&) {
  return 0;
}
template <IsScalar T>
inline T dot(const T& a, const T& b) {
  return a * b;
}
/// World direction of a node's rotation axis: a plain 1, so that the compiler can drop the multiplication.
template <class T>
inline double revolute_axis(const PlanarRotation<T>&) {
  return 1;
}
/// Component of an angular quantity along the rotation axis.
template <class T>
requires(!std::is_same_v<T, double>) inline T dot(double a, const T& b) { return a * b; }
template <class A, class B>
inline Vector2Of<ProductOf<A, B>> operator*(const PlanarRotation<A>& R, const Vector2Of<B>& v) {
  return {R.c * v.x() - R.s * v.y(), R.s * v.x() + R.c * v.y()};
}
template <class T>
inline T operator*(const PlanarRotation<T>&, const T& w) {
  return w;
}
template <class T>
inline Vector2Of<T> rotate_inverse(const PlanarRotation<T>& R, const Vector2Of<T>& v) {
  return {R.c * v.x() + R.s * v.y(), R.c * v.y() - R.s * v.x()};
}
template <class T>
inline T rotate_inverse(const PlanarRotation<T>&, const T& w) {
  return w;
}
template <class A, class B>
inline PlanarRotation<ProductOf<A, B>> operator*(const PlanarRotation<A>& a, const PlanarRotation<B>& b) {
  return {a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}
/// R followed by a rotation about the joint axis.
template <class T>
inline PlanarRotation<T> rotate_about_joint_axis(const PlanarRotation<ModelScalarOf<T>>& R, const T& c, const T& s) {
  return R * PlanarRotation<T>{c, s};
}
/// Axis k (0: x, 1: y) of the rotated frame.
template <class T>
inline Vector2Of<T> axis(const PlanarRotation<T>& R, int k) {
  return k == 0 ? Vector2Of<T>(R.c, R.s) : Vector2Of<T>(-R.s, R.c);
}
template <class T>
inline T gyroscopic(const T&, const ModelScalarOf<T>&) {
  return 0;
}

template <class A, class B>
inline Vector2Of<ProductOf<A, B>> times(const PlanarAccelerationOperator<A>& K, const Vector2Of<B>& v) {
  return {-K.alpha * v.y() - K.square * v.x(), K.alpha * v.x() - K.square * v.y()};
}
template <class T>
inline PlanarAccelerationOperator<T> make_acceleration_operator(const T& w, const T& alpha) {
  return {alpha, w * w};
}
template <class T>
inline T times(const ModelScalarOf<T>& m, const T& v) {
  return m * v;
}

// Components about and along the joint axis, written out because the compiler may not drop products with zero.
template <class T>
inline void add_to_axis_component(T& w, const T& rate) {
  w += rate;
}
/// ω × (rate about the axis).
template <class T>
inline T cross_with_axis(const T&, const T&) {
  return 0;
}
template <class T>
inline T axis_component(const T& moment) {
  return moment;
}
template <class T>
inline T slide_component(const Vector2Of<T>& v) {
  return v.x();
}
template <class T>
inline void add_to_slide_component(Vector2Of<T>& v, const T& rate) {
  v.x() += rate;
}
template <class T>
inline Vector2Of<T> prismatic_axis(const PlanarRotation<T>& R) {
  return {R.c, R.s};
}

/// The algebra of space: angular quantities are vectors, rotations matrices.
template <class T>
struct SpatialRotation {
  Matrix3Of<T> matrix = Matrix3Of<T>::Identity();
};

/// Conversion to another scalar type.
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
  using AccelerationOperator = Matrix3Of<T>;  ///< maps a vector fixed to a rotating frame to its second derivative

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

using Planar = PlanarOf<double>;
using Spatial = SpatialOf<double>;

/// The space of the mechanism's own constants for motions computed in S.
template <class S>
using Constants = typename S::Constants;

template <class S>
inline constexpr bool is_planar = S::dimension == 2;

/// Calls `function` with a value of the mechanism's space and returns the result:
/// `dispatch_space(mechanism.space, [&]<class S>(S) { return find<S>(mechanism); })`.
template <class Function>
auto dispatch_space(SpaceKind space, const Function& function) {
  return space == SpaceKind::planar ? function(Planar{}) : function(Spatial{});
}

// ---- conversions from the model's three-dimensional values ----

template <class S>
typename S::Vector to_vector(const Vector3Of<typename S::Scalar>& v) {
  return v.template head<S::dimension>();
}

template <class T>
Vector3Of<T> to_3d(const Vector2Of<T>& v) {
  return {v.x(), v.y(), T(0)};
}
template <class T>
Vector3Of<T> to_3d(const Vector3Of<T>& v) {
  return v;
}
/// An angular quantity as a vector (planar: along z).
template <class T>
Vector3Of<T> angular_to_3d(const T& w) {
  return {T(0), T(0), w};
}
template <class T>
Vector3Of<T> angular_to_3d(const Vector3Of<T>& w) {
  return w;
}

template <class S>
typename S::Rotation to_rotation(const Matrix3Of<typename S::Scalar>& R) {
  if constexpr (is_planar<S>)
    return {R(0, 0), R(1, 0)};
  else
    return {R};
}

template <class T>
Matrix3Of<T> to_matrix(const PlanarRotation<T>& R) {
  Matrix3Of<T> m = Matrix3Of<T>::Identity();
  m.template topLeftCorner<2, 2>() << R.c, -R.s, R.s, R.c;
  return m;
}
template <class T>
Matrix3Of<T> to_matrix(const SpatialRotation<T>& R) {
  return R.matrix;
}

template <class S>
typename S::Angular to_angular(const Vector3Of<typename S::Scalar>& w) {
  if constexpr (is_planar<S>)
    return w.z();
  else
    return w;
}

}  // namespace balance::kinematics
