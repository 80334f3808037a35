#pragma once
/// The algebra of the plane: angular quantities are scalars, rotations unit complex numbers. Private to the rooms of kinematics, motion and dynamics.

#include "balance/base/types.hpp"

#include <type_traits>

namespace balance {

/// Unit complex number.
template <class T>
struct PlanarRotation {
  T c = 1, s = 0;
};

/// What the velocity and acceleration of a frame do to a vector fixed to it: v ↦ α × v + ω × (ω × v).
template <class T>
struct PlanarAccelerationOperator {
  T alpha, square;
};

/// The same in other numbers.
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

  /// About the origin of the frame it is given in.
  struct Inertia {
    T mass = 0;
    Vector first_moment = Vector::Zero();  ///< first moment of mass
    T second_moment = 0;                   ///< moment of inertia about the origin
  };

  static Vector slide_direction() { return Vector::UnitX(); }
  static T zero_angular() { return 0; }
  static AccelerationOperator zero_acceleration_operator() { return {0, 0}; }
};

/// No vector.
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
/// World direction of the axis that a node's joint turns about: a plain one, by which the compiler need not multiply.
template <class T>
inline double revolute_axis(const PlanarRotation<T>&) {
  return 1;
}
/// Of a vector along the turn axis.
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
/// R followed by a turn about the joint axis.
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

// About and along the joint axis, written out because the compiler may not drop a product with zero.
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

}  // namespace balance
