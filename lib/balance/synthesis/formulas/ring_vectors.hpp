#pragma once
/// Vectors and symmetric matrices over any ring of scalars.

#include <array>
#include <cstddef>

namespace balance::formulas {

template <class R>
using RingVector3 = std::array<R, 3>;
/// Entries xx, yy, zz, xy, xz, yz.
template <class R>
using RingSymmetric3 = std::array<R, 6>;

template <class R>
RingVector3<R> operator+(const RingVector3<R>& a, const RingVector3<R>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class R>
RingVector3<R> operator-(const RingVector3<R>& a, const RingVector3<R>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class R>
RingVector3<R> scale_vector(const R& s, const RingVector3<R>& v) {
  return {s * v[0], s * v[1], s * v[2]};
}
template <class R>
RingVector3<R> cross(const RingVector3<R>& a, const RingVector3<R>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class R>
R dot(const RingVector3<R>& a, const RingVector3<R>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class R>
RingVector3<R> operator*(const RingSymmetric3<R>& I, const RingVector3<R>& w) {
  return {I[0] * w[0] + I[3] * w[1] + I[4] * w[2], I[3] * w[0] + I[1] * w[1] + I[5] * w[2],
          I[4] * w[0] + I[5] * w[1] + I[2] * w[2]};
}
template <class R>
RingVector3<R> unit_vector(int axis, const R& length) {
  RingVector3<R> e{R(0), R(0), R(0)};
  e[static_cast<std::size_t>(axis)] = length;
  return e;
}
/// Index of the entry (i, j), i ≠ j, of a symmetric matrix.
constexpr std::size_t off_diagonal_index(std::size_t i, std::size_t j) { return i + j == 1 ? 3 : i + j == 2 ? 4 : 5; }

/// Mass, first moment and inertia about the origin of the frame in which they are given.
template <class R>
struct RigidBodyInertia {
  R mass = R(0);
  RingVector3<R> moment{R(0), R(0), R(0)};
  RingSymmetric3<R> inertia{R(0), R(0), R(0), R(0), R(0), R(0)};

  RigidBodyInertia& operator+=(const RigidBodyInertia& other) {
    mass = mass + other.mass;
    for (std::size_t k = 0; k < 3; ++k) moment[k] = moment[k] + other.moment[k];
    for (std::size_t k = 0; k < 6; ++k) inertia[k] = inertia[k] + other.inertia[k];
    return *this;
  }
};

/// The same about a new origin at −d: in the new frame, the old origin is at d.
template <class R>
RigidBodyInertia<R> shift_origin(const RigidBodyInertia<R>& body, const RingVector3<R>& d) {
  const auto& [m, h, I] = body;
  RigidBodyInertia<R> shifted = body;
  const R hd = R(2) * dot(h, d), dd = dot(d, d);
  for (std::size_t k = 0; k < 3; ++k) {
    shifted.moment[k] = h[k] + m * d[k];
    shifted.inertia[k] = I[k] + hd - R(2) * (h[k] * d[k]) + m * (dd - d[k] * d[k]);
  }
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 3; ++j) {
      R& entry = shifted.inertia[off_diagonal_index(i, j)];
      entry = entry - (h[i] * d[j] + d[i] * h[j] + m * (d[i] * d[j]));
    }
  return shifted;
}

}  // namespace balance::formulas
