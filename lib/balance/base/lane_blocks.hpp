#pragma once
/// Factorisation and solution of small dense blocks, one in every lane, with an order of pivots that all lanes share where it suits
/// them. Row-major storage. Private to base.

#include "balance/base/pack.hpp"
#include "balance/base/small_blocks.hpp"

#include <limits>
#include <vector>

namespace balance::lane_blocks {

/// Larger multipliers than this show that the order of rows does not suit a lane.
inline constexpr double max_multiplier = 8;

template <class M, class T>
void exchange(const M& lanes, T& a, T& b) {
  const T former = a;
  a = select(lanes, b, a);
  b = select(lanes, former, b);
}

template <class T>
using MaskOf = decltype(T() < T());

/// Two rows that change places in some lanes.
template <class T>
struct RowExchange {
  MaskOf<T> lanes;
  int row, other;
};
template <class T>
using RowExchanges = std::vector<RowExchange<T>>;

template <class T>
struct Elimination {
  MaskOf<T> needs_pivoting;  ///< where the multipliers grew
  T min_pivot;               ///< smallest |pivot|
};

/// The smallest pivot so far; 0 once one is none.
template <class T>
void update_min_pivot(T& quality, const T& pivot) {
  quality = select(pivot > 0.0, min(quality, pivot), T(0.0));
}

/// Column k is eliminated below row k; the diagonal keeps the pivot's reciprocal.
/// @return the largest multiplier
template <class T>
T eliminate_column(T* a, int n, int k) {
  const T inverse = 1.0 / a[k * n + k];
  a[k * n + k] = inverse;
  T largest = 0.0;
  for (int i = k + 1; i < n; ++i) {
    const T factor = a[i * n + k] *= inverse;
    largest = max(largest, abs(factor));
    for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
  }
  return largest;
}

/// In place, rows as they stand. N: the size where it is known when compiling, else 0.
template <int N, class T>
Elimination<T> eliminate(T* a, int size) {
  const int n = N > 0 ? N : size;
  T quality = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (int k = 0; k < n; ++k) {
    update_min_pivot(quality, abs(a[k * n + k]));
    largest = max(largest, eliminate_column(a, n, k));
  }
  return {(largest > max_multiplier) | (quality <= 0.0), quality};
}

/// The same with the largest pivot of every column in the `lanes` given; the others keep their order, and thus every bit.
template <int N, class T>
Elimination<T> eliminate_with_pivoting(T* a, int size, const MaskOf<T>& lanes, RowExchanges<T>& exchanges) {
  const int n = N > 0 ? N : size;
  T quality = std::numeric_limits<double>::infinity();
  for (int k = 0; k < n; ++k) {
    for (int i = k + 1; i < n; ++i) {
      const MaskOf<T> larger = lanes & (abs(a[i * n + k]) > abs(a[k * n + k]));
      if (!any(larger)) continue;
      for (int j = 0; j < n; ++j) exchange(larger, a[k * n + j], a[i * n + j]);
      exchanges.push_back({larger, k, i});
    }
    update_min_pivot(quality, abs(a[k * n + k]));
    eliminate_column(a, n, k);
  }
  return {lanes, quality};
}

template <int N, class T>
void solve(const T* a, int size, T* x) {
  const int n = N > 0 ? N : size;
  for (int i = 1; i < n; ++i)
    for (int j = 0; j < i; ++j) x[i] -= a[i * n + j] * x[j];
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) x[i] -= a[i * n + j] * x[j];
    x[i] *= a[i * n + i];
  }
}

template <int N, class T>
void solve_transposed(const T* a, int size, T* x) {
  const int n = N > 0 ? N : size;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) x[i] -= a[j * n + i] * x[j];
    x[i] *= a[i * n + i];
  }
  for (int i = n - 1; i >= 0; --i)
    for (int j = i + 1; j < n; ++j) x[i] -= a[j * n + i] * x[j];
}

}  // namespace balance::lane_blocks
