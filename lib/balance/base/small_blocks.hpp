#pragma once
/// Factorisation and solution of the small dense blocks that sparse systems of mechanisms fall apart into. Row-major storage.
/// Private to base.

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace balance::small_blocks {

/// In place, with row exchanges; the diagonal holds the pivots' reciprocals. N is the size where it is known when compiling:
/// the blocks of most mechanisms are so small that loops would cost more than the arithmetic.
/// Returns the smallest pivot.
template <int N>
double factorise_block(double* a, int* pivots, int size) {
  const int n = N > 0 ? N : size;
  double smallest = INFINITY;
  for (int k = 0; k < n; ++k) {
    int best = k;
    double largest = std::abs(a[k * n + k]);
    for (int i = k + 1; i < n; ++i)
      if (std::abs(a[i * n + k]) > largest) largest = std::abs(a[i * n + k]), best = i;
    pivots[k] = best;
    if (best != k)
      for (int j = 0; j < n; ++j) std::swap(a[k * n + j], a[best * n + j]);
    smallest = std::min(smallest, largest);
    if (!(largest > 0)) return 0;
    const double inverse = 1 / a[k * n + k];
    a[k * n + k] = inverse;
    for (int i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] *= inverse;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return smallest;
}

// x −= a y and x *= a, for numbers and for pairs of them; for duals: base/square_system.hpp.
inline void subtract(double& x, double a, double y) { x -= a * y; }
inline void scale(double& x, double a) { x *= a; }
template <class Pair>
void subtract(Pair& x, double a, const Pair& y) {
  x.x -= a * y.x;
  x.z -= a * y.z;
}
template <class Pair>
void scale(Pair& x, double a) {
  x.x *= a;
  x.z *= a;
}

/// The unknowns of a small block live in registers. X: a number or several.
template <int N, class X>
struct RegisterVector {
  X values[N];
  explicit RegisterVector(const X* x) {
    for (int i = 0; i < N; ++i) values[i] = x[i];
  }
  void store(X* x) const {
    for (int i = 0; i < N; ++i) x[i] = values[i];
  }
  X& operator[](int i) { return values[i]; }
};
template <class X>
struct RegisterVector<0, X> {
  X* x;
  explicit RegisterVector(X* values) : x(values) {}
  void store(X*) const {}
  X& operator[](int i) { return x[i]; }
};

template <int N, class X>
void solve_block(const double* a, const int* pivots, int size, X* x) {
  const int n = N > 0 ? N : size;
  for (int k = 0; k < n; ++k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
  RegisterVector<N, X> v(x);
  for (int i = 1; i < n; ++i)
    for (int j = 0; j < i; ++j) subtract(v[i], a[i * n + j], v[j]);
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) subtract(v[i], a[i * n + j], v[j]);
    scale(v[i], a[i * n + i]);
  }
  v.store(x);
}

template <int N, class X>
void solve_block_transposed(const double* a, const int* pivots, int size, X* x) {
  const int n = N > 0 ? N : size;
  RegisterVector<N, X> v(x);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) subtract(v[i], a[j * n + i], v[j]);
    scale(v[i], a[i * n + i]);
  }
  for (int i = n - 1; i >= 0; --i)
    for (int j = i + 1; j < n; ++j) subtract(v[i], a[j * n + i], v[j]);
  v.store(x);
  for (int k = n - 1; k >= 0; --k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
}

/// Largest block that is inverted by cofactors: one division instead of a chain of them, and products that need not wait for
/// each other.
inline constexpr int max_inverted_size = 3;

/// 1/largest entry of the inverse: no larger than the smallest singular value times the size. 0 if singular.
inline double scale_inverse(double* inverse, int entries, double determinant) {
  if (!(std::abs(determinant) > 0)) return 0;
  const double scale = 1 / determinant;
  double largest = 0;
  for (int i = 0; i < entries; ++i) {
    inverse[i] *= scale;
    largest = std::max(largest, std::abs(inverse[i]));
  }
  return 1 / largest;
}

inline double invert(std::integral_constant<int, 1>, double* a) {
  const double determinant = a[0];
  a[0] = 1;
  return scale_inverse(a, 1, determinant);
}

inline double invert(std::integral_constant<int, 2>, double* a) {
  const double determinant = a[0] * a[3] - a[1] * a[2];
  std::swap(a[0], a[3]);
  a[1] = -a[1];
  a[2] = -a[2];
  return scale_inverse(a, 4, determinant);
}

inline double invert(std::integral_constant<int, 3>, double* a) {
  const double c[9] = {a[4] * a[8] - a[5] * a[7], a[2] * a[7] - a[1] * a[8], a[1] * a[5] - a[2] * a[4],
                       a[5] * a[6] - a[3] * a[8], a[0] * a[8] - a[2] * a[6], a[2] * a[3] - a[0] * a[5],
                       a[3] * a[7] - a[4] * a[6], a[1] * a[6] - a[0] * a[7], a[0] * a[4] - a[1] * a[3]};
  const double determinant = a[0] * c[0] + a[1] * c[3] + a[2] * c[6];
  std::copy_n(c, 9, a);
  return scale_inverse(a, 9, determinant);
}

template <int N, class X>
void multiply(const double* inverse, X* x) {
  const RegisterVector<N, X> v(x);
  for (int i = 0; i < N; ++i) {
    X sum = v.values[0];
    scale(sum, inverse[i * N]);
    for (int j = 1; j < N; ++j) subtract(sum, -inverse[i * N + j], v.values[j]);
    x[i] = sum;
  }
}

template <int N, class X>
void multiply_transposed(const double* inverse, X* x) {
  const RegisterVector<N, X> v(x);
  for (int i = 0; i < N; ++i) {
    X sum{};
    for (int j = 0; j < N; ++j) subtract(sum, -inverse[j * N + i], v.values[j]);
    x[i] = sum;
  }
}

/// Calls `work` with the size as a compile-time constant where it is small, else 0.
template <class Work>
auto dispatch_by_size(int n, const Work& work) {
  switch (n) {
    case 1: return work(std::integral_constant<int, 1>{});
    case 2: return work(std::integral_constant<int, 2>{});
    case 3: return work(std::integral_constant<int, 3>{});
    case 4: return work(std::integral_constant<int, 4>{});
    case 5: return work(std::integral_constant<int, 5>{});
    case 6: return work(std::integral_constant<int, 6>{});
    default: return work(std::integral_constant<int, 0>{});
  }
}

}  // namespace balance::small_blocks
