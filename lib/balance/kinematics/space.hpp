#pragma once
/// The algebra that the recursions are written over, once for the plane and once for space, each over any scalar T. A Space has
/// vectors (places, forces), angular quantities (scalars in the plane, vectors in space), rotations and inertias. Private to the
/// rooms of kinematics, motion and dynamics.

#include "balance/base/dual.hpp"
#include "balance/kinematics/planar.hpp"
#include "balance/kinematics/spatial.hpp"
#include "balance/model/mechanism.hpp"

namespace balance {

using Planar = PlanarOf<double>;
using Spatial = SpatialOf<double>;

/// The space of the mechanism's own numbers where a motion's are those of S.
template <class S>
using Constants = typename S::Constants;

template <class S>
inline constexpr bool is_planar = S::dimension == 2;

/// What `found` gives for the algebra of a mechanism's space, of which it is called with a value:
/// `in_space(mechanism.space, [&]<class S>(S) { return find<S>(mechanism); })`.
template <class Function>
auto dispatch_space(SpaceKind space, const Function& found) {
  return space == SpaceKind::planar ? found(Planar{}) : found(Spatial{});
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

}  // namespace balance
