#pragma once
/// The algebra that the recursions are written over, once for the plane and once for space. A Space has vectors (places,
/// forces), angular quantities (scalars in the plane, vectors in space), rotations and inertias. Private to the rooms of
/// kinematics, motion and dynamics.

#include "balance/base/types.hpp"
#include "balance/model/mechanism.hpp"

#include <cmath>

namespace balance {

struct Planar {
  static constexpr int dimension = 2;   ///< components of a vector
  static constexpr int angular = 1;     ///< components of an angular quantity
  static constexpr int parameters = 4;  ///< inertial parameters of a body: m, mx, my, J
  using Vector = Vector2;
  using Angular = double;

  /// Unit complex number.
  struct Rotation {
    double c = 1, s = 0;
  };

  /// About the origin of the frame it is given in.
  struct Inertia {
    double mass = 0;
    Vector2 moment = Vector2::Zero();  ///< first moment of mass
    double second = 0;                 ///< moment of inertia about the origin
  };

  static Vector2 slide_direction() { return Vector2::UnitX(); }
  static double zero_angular() { return 0; }
};

struct Spatial {
  static constexpr int dimension = 3;
  static constexpr int angular = 3;
  static constexpr int parameters = 10;  ///< m, mx, my, mz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz
  using Vector = Vector3;
  using Angular = Vector3;

  struct Rotation {
    Matrix3 matrix = Matrix3::Identity();
  };

  struct Inertia {
    double mass = 0;
    Vector3 moment = Vector3::Zero();
    Matrix3 second = Matrix3::Zero();
  };

  static Vector3 slide_direction() { return Vector3::UnitZ(); }
  static Vector3 zero_angular() { return Vector3::Zero(); }
};

// ---- the plane ----

inline Vector2 cross(double w, const Vector2& r) { return {-w * r.y(), w * r.x()}; }
inline double cross(const Vector2& r, const Vector2& f) { return r.x() * f.y() - r.y() * f.x(); }
inline double cross(double, double) { return 0; }
inline double dot(double a, double b) { return a * b; }
/// World direction of the axis that a node's joint turns about.
inline double turn_axis(const Planar::Rotation&) { return 1; }
inline Vector2 operator*(const Planar::Rotation& R, const Vector2& v) {
  return {R.c * v.x() - R.s * v.y(), R.s * v.x() + R.c * v.y()};
}
inline double operator*(const Planar::Rotation&, double w) { return w; }
inline Vector2 unrotate(const Planar::Rotation& R, const Vector2& v) {
  return {R.c * v.x() + R.s * v.y(), R.c * v.y() - R.s * v.x()};
}
inline double unrotate(const Planar::Rotation&, double w) { return w; }
inline Planar::Rotation operator*(const Planar::Rotation& a, const Planar::Rotation& b) {
  return {a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}
/// R followed by a turn about the joint axis.
inline Planar::Rotation turned(const Planar::Rotation& R, double c, double s) { return R * Planar::Rotation{c, s}; }
/// Axis k (0: x, 1: y) of the rotated frame.
inline Vector2 axis(const Planar::Rotation& R, int k) { return k == 0 ? Vector2(R.c, R.s) : Vector2(-R.s, R.c); }
inline double gyroscopic(double, double) { return 0; }

/// What the velocity and acceleration of a frame do to a vector fixed to it: v ↦ α × v + ω × (ω × v).
struct PlanarTurning {
  double alpha, square;
  Vector2 operator*(const Vector2& v) const {
    return {-alpha * v.y() - square * v.x(), alpha * v.x() - square * v.y()};
  }
};
inline Vector2 times(const PlanarTurning& K, const Vector2& v) { return K * v; }
inline PlanarTurning turning(double w, double alpha) { return {alpha, w * w}; }

// About and along the joint axis, written out because the compiler may not drop a product with zero.
inline void add_about_axis(double& w, double rate) { w += rate; }
/// ω × (rate about the axis).
inline double cross_with_axis(double, double) { return 0; }
inline double about_axis(double moment) { return moment; }
inline double along_slide(const Vector2& v) { return v.x(); }
inline void add_along_slide(Vector2& v, double rate) { v.x() += rate; }
inline Vector2 slide_axis(const Planar::Rotation& R) { return {R.c, R.s}; }

// ---- space ----

inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}
inline double dot(const Vector3& a, const Vector3& b) { return a.x() * b.x() + a.y() * b.y() + a.z() * b.z(); }
inline double dot(const Vector2& a, const Vector2& b) { return a.x() * b.x() + a.y() * b.y(); }
inline Vector3 turn_axis(const Spatial::Rotation& R) { return R.matrix.col(2); }
/// M v, written out: for three rows the general product spends more on its loop than on its arithmetic.
inline Vector3 times(const Matrix3& M, const Vector3& v) {
  const double x = v.x(), y = v.y(), z = v.z();
  return {M(0, 0) * x + M(0, 1) * y + M(0, 2) * z, M(1, 0) * x + M(1, 1) * y + M(1, 2) * z,
          M(2, 0) * x + M(2, 1) * y + M(2, 2) * z};
}
inline double times(double m, double v) { return m * v; }
inline Vector3 operator*(const Spatial::Rotation& R, const Vector3& v) { return times(R.matrix, v); }
inline Vector3 unrotate(const Spatial::Rotation& R, const Vector3& v) {
  const Matrix3& M = R.matrix;
  const double x = v.x(), y = v.y(), z = v.z();
  return {M(0, 0) * x + M(1, 0) * y + M(2, 0) * z, M(0, 1) * x + M(1, 1) * y + M(2, 1) * z,
          M(0, 2) * x + M(1, 2) * y + M(2, 2) * z};
}
inline Spatial::Rotation operator*(const Spatial::Rotation& a, const Spatial::Rotation& b) {
  return {Matrix3(a.matrix * b.matrix)};
}
inline Spatial::Rotation turned(const Spatial::Rotation& R, double c, double s) {
  Spatial::Rotation out;
  out.matrix.col(0) = c * R.matrix.col(0) + s * R.matrix.col(1);
  out.matrix.col(1) = c * R.matrix.col(1) - s * R.matrix.col(0);
  out.matrix.col(2) = R.matrix.col(2);
  return out;
}
inline Vector3 axis(const Spatial::Rotation& R, int k) { return R.matrix.col(k); }
/// ω × Jω.
inline Vector3 gyroscopic(const Vector3& w, const Matrix3& J) { return cross(w, times(J, w)); }

inline Matrix3 turning(const Vector3& w, const Vector3& alpha) {
  const double xx = w.x() * w.x(), yy = w.y() * w.y(), zz = w.z() * w.z();
  const double xy = w.x() * w.y(), xz = w.x() * w.z(), yz = w.y() * w.z();
  Matrix3 K;
  K << -yy - zz, xy - alpha.z(), xz + alpha.y(), xy + alpha.z(), -xx - zz, yz - alpha.x(), xz - alpha.y(),
      yz + alpha.x(), -xx - yy;
  return K;
}
inline void add_about_axis(Vector3& w, double rate) { w.z() += rate; }
inline Vector3 cross_with_axis(const Vector3& w, double rate) { return {w.y() * rate, -w.x() * rate, 0}; }
inline double about_axis(const Vector3& moment) { return moment.z(); }
inline double along_slide(const Vector3& v) { return v.z(); }
inline void add_along_slide(Vector3& v, double rate) { v.z() += rate; }
inline Vector3 slide_axis(const Spatial::Rotation& R) { return R.matrix.col(2); }

// ---- conversions from the model's three-dimensional values ----

template <class S>
typename S::Vector to_vector(const Vector3& v) {
  return v.head<S::dimension>();
}

inline Vector3 to_3d(const Vector2& v) { return {v.x(), v.y(), 0}; }
inline Vector3 to_3d(const Vector3& v) { return v; }
/// An angular quantity as a vector (planar: along z).
inline Vector3 angular_to_3d(double w) { return {0, 0, w}; }
inline Vector3 angular_to_3d(const Vector3& w) { return w; }

template <class S>
typename S::Rotation to_rotation(const Matrix3& R);
template <>
inline Planar::Rotation to_rotation<Planar>(const Matrix3& R) {
  return {R(0, 0), R(1, 0)};
}
template <>
inline Spatial::Rotation to_rotation<Spatial>(const Matrix3& R) {
  return {R};
}

inline Matrix3 to_matrix(const Planar::Rotation& R) {
  Matrix3 m = Matrix3::Identity();
  m.topLeftCorner<2, 2>() << R.c, -R.s, R.s, R.c;
  return m;
}
inline Matrix3 to_matrix(const Spatial::Rotation& R) { return R.matrix; }

template <class S>
typename S::Angular to_angular(const Vector3& w);
template <>
inline double to_angular<Planar>(const Vector3& w) {
  return w.z();
}
template <>
inline Vector3 to_angular<Spatial>(const Vector3& w) {
  return w;
}

}  // namespace balance
