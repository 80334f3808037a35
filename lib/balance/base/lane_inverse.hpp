#pragma once
/// Inverses of the smallest dense blocks, one in every lane, by cofactors: no pivots to choose. Row-major storage. Private to base.

#include "balance/base/pack.hpp"

#include <type_traits>

namespace balance::lane_blocks {

/// Largest block that is inverted.
inline constexpr int max_inverted_size = 4;

/// The matrix of cofactors over the determinant.
/// @return 1/largest entry, no larger than the smallest singular value times the size
template <int N, class T>
T scale_inverse(const T (&cofactors)[N * N], const T& determinant, T* inverse) {
  const T scale = 1.0 / determinant;
  T largest = 0.0;
  for (int i = 0; i < N * N; ++i) {
    inverse[i] = scale * cofactors[i];
    largest = max(largest, abs(inverse[i]));
  }
  return select((abs(determinant) > 0.0) & (largest > 0.0), 1.0 / largest, T(0.0));  // false for NaN
}

template <class T>
T invert(std::integral_constant<int, 1>, T* a) {
  const T one[1] = {1.0};
  return scale_inverse<1>(one, T(a[0]), a);
}

template <class T>
T invert(std::integral_constant<int, 2>, T* a) {
  const T c[4] = {a[3], -a[1], -a[2], a[0]};
  return scale_inverse<2>(c, T(a[0] * a[3] - a[1] * a[2]), a);
}

template <class T>
T invert(std::integral_constant<int, 3>, T* a) {
  const T c[9] = {a[4] * a[8] - a[5] * a[7], a[2] * a[7] - a[1] * a[8], a[1] * a[5] - a[2] * a[4],
                  a[5] * a[6] - a[3] * a[8], a[0] * a[8] - a[2] * a[6], a[2] * a[3] - a[0] * a[5],
                  a[3] * a[7] - a[4] * a[6], a[1] * a[6] - a[0] * a[7], a[0] * a[4] - a[1] * a[3]};
  return scale_inverse<3>(c, T(a[0] * c[0] + a[1] * c[3] + a[2] * c[6]), a);
}

/// Laplace's expansion along the first two rows.
template <class T>
T invert(std::integral_constant<int, 4>, T* a) {
  const auto minor = [a](int row, int i, int j) { return a[row + i] * a[row + 4 + j] - a[row + j] * a[row + 4 + i]; };
  const T s0 = minor(0, 0, 1), s1 = minor(0, 0, 2), s2 = minor(0, 0, 3), s3 = minor(0, 1, 2), s4 = minor(0, 1, 3),
          s5 = minor(0, 2, 3), c0 = minor(8, 0, 1), c1 = minor(8, 0, 2), c2 = minor(8, 0, 3), c3 = minor(8, 1, 2),
          c4 = minor(8, 1, 3), c5 = minor(8, 2, 3);
  const T c[16] = {
      a[5] * c5 - a[6] * c4 + a[7] * c3,    a[2] * c4 - a[1] * c5 - a[3] * c3,    a[13] * s5 - a[14] * s4 + a[15] * s3,
      a[10] * s4 - a[9] * s5 - a[11] * s3,  a[6] * c2 - a[4] * c5 - a[7] * c1,    a[0] * c5 - a[2] * c2 + a[3] * c1,
      a[14] * s2 - a[12] * s5 - a[15] * s1, a[8] * s5 - a[10] * s2 + a[11] * s1,  a[4] * c4 - a[5] * c2 + a[7] * c0,
      a[1] * c2 - a[0] * c4 - a[3] * c0,    a[12] * s4 - a[13] * s2 + a[15] * s0, a[9] * s2 - a[8] * s4 - a[11] * s0,
      a[5] * c1 - a[4] * c3 - a[6] * c0,    a[0] * c3 - a[1] * c1 + a[2] * c0,    a[13] * s1 - a[12] * s3 - a[14] * s0,
      a[8] * s3 - a[9] * s1 + a[10] * s0};
  return scale_inverse<4>(c, T(s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0), a);
}

template <int N, class T>
void multiply(const T* inverse, T* x) {
  T v[N];
  for (int i = 0; i < N; ++i) v[i] = x[i];
  for (int i = 0; i < N; ++i) {
    T sum = inverse[i * N] * v[0];
    for (int j = 1; j < N; ++j) sum += inverse[i * N + j] * v[j];
    x[i] = sum;
  }
}

template <int N, class T>
void multiply_transposed(const T* inverse, T* x) {
  T v[N];
  for (int i = 0; i < N; ++i) v[i] = x[i];
  for (int i = 0; i < N; ++i) {
    T sum = inverse[i] * v[0];
    for (int j = 1; j < N; ++j) sum += inverse[j * N + i] * v[j];
    x[i] = sum;
  }
}

}  // namespace balance::lane_blocks
