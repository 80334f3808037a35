#pragma once
/// A block triangular system (BlockTriangular) for several samples at once: one matrix per lane, all of the same
/// pattern, with rows in the pivot order of one factorised scalar matrix. A lane that this order does not suit gets its
/// own, and a lane with a singular matrix is reported. Neither changes a bit of the other lanes' results.

#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/square_system.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace balance::numerics::lane_blocks {

// Factorisation and solution of small dense blocks, one per lane, with a pivot order shared by all lanes that it suits.
// Row-major storage.

/// Larger multipliers mean that the order of rows does not suit a lane.
inline constexpr double max_multiplier = 8;

template <class M, class T>
void exchange(const M& lanes, T& a, T& b) {
  const T former = a;
  a = select(lanes, b, a);
  b = select(lanes, former, b);
}

template <class T>
using MaskOf = decltype(T() < T());

/// Two rows exchanged in some lanes.
template <class T>
struct RowExchange {
  MaskOf<T> lanes;
  int row, other;
};
template <class T>
using RowExchanges = std::vector<RowExchange<T>>;

template <class T>
struct Elimination {
  MaskOf<T> needs_pivoting;  ///< lanes with large multipliers or a vanishing pivot
  T min_pivot;               ///< smallest |pivot|
};

/// Updates the smallest pivot, which becomes and stays 0 if a pivot is not positive.
template <class T>
void update_min_pivot(T& quality, const T& pivot) {
  quality = select(pivot > 0.0, min(quality, pivot), T(0.0));
}

/// Eliminates column k below row k; the diagonal keeps the reciprocal of the pivot.
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

/// In place, without row exchanges. N: the size if it is known at compile time, else 0.
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

/// The same with partial pivoting in the given `lanes`; the others keep their order, and thus every bit.
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

// Inverses of the smallest dense blocks, one per lane, by cofactors, which needs no pivoting. Row-major storage.

/// Largest block that is inverted.
inline constexpr int max_inverted_size = 4;

/// Divides the cofactors by the determinant.
/// @return 1/|largest entry|, at most the smallest singular value times the size; 0 if singular
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
  const T cofactors[1] = {1.0};
  return scale_inverse<1>(cofactors, T(a[0]), a);
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

/// Laplace expansion along the first two rows.
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

}  // namespace balance::numerics::lane_blocks

namespace balance::numerics {

/// @tparam T Pack<W>
template <class T>
class LaneBlockTriangular {
 public:
  /// @param scalar factorised for a state near those of the lanes
  explicit LaneBlockTriangular(const BlockTriangular& scalar) : scalar_(scalar), structure_(scalar.structure()) {
    const auto n = static_cast<std::size_t>(size());
    values_.assign(scalar.entry_count(), T(0.0));
    work_.assign(n, T(0.0));
    factors_.assign(static_cast<std::size_t>(structure_.diagonal_entries), T(0.0));
    row_exchanges_.resize(structure_.blocks.size());
    quality_.assign(structure_.blocks.size(), T(0.0));
    pivot_order_.resize(n);
    set_pivot_order(scalar);
  }

  /// Adopts the pivot order of another matrix of the same pattern.
  void set_pivot_order(const BlockTriangular& scalar) {
    structure_.row_exchanges = scalar.structure().row_exchanges;
    for (const BlockTriangular::Block& block : structure_.blocks) {
      for (int i = 0; i < block.size; ++i) pivot_order_[block.begin + i] = block.begin + i;
      if (block.size > lane_blocks::max_inverted_size)
        for (int i = 0; i < block.size; ++i)
          std::swap(pivot_order_[block.begin + i],
                    pivot_order_[block.begin + structure_.row_exchanges[block.begin + i]]);
    }
  }

  int size() const { return static_cast<int>(structure_.row_position.size()); }
  /// As in BlockTriangular, whose index() applies here too.
  T* storage() { return values_.data(); }
  const T* storage() const { return values_.data(); }
  int index(int row, int column) const { return scalar_.index(row, column); }
  T& at(int row, int column) { return values_[static_cast<std::size_t>(scalar_.index(row, column))]; }

  /// @return per lane the smallest |pivot| or 1/|entry of an inverse|, at most 1; 0 if singular or not finite
  T factorise() {
    T quality = 1.0;
    for (std::size_t b = 0; b < structure_.blocks.size(); ++b) {
      const BlockTriangular::Block& block = structure_.blocks[b];
      quality_[b] = small_blocks::dispatch_by_size(
          block.size, [&](auto size) { return factorise_block<size>(block, row_exchanges_[b]); });
      quality = min(quality, quality_[b]);
    }
    return select(quality > 0.0, quality, T(0.0));
  }

  const std::vector<BlockTriangular::Block>& blocks() const { return structure_.blocks; }
  /// For one diagonal block of the last factorisation, as in factorise().
  const T& min_pivot(std::size_t block) const { return quality_[block]; }
  /// x := A_bb⁻¹ x for diagonal block b. @param x twice as long as the block: work space follows the right-hand side
  void solve_in_block(std::size_t b, T* x) {
    const Block& block = structure_.blocks[b];
    T* work = &work_[block.begin];
    std::copy_n(x, block.size, work);
    small_blocks::dispatch_by_size(block.size,
                                   [&](auto size) { solve_block<size>(block, row_exchanges_[b], x + block.size); });
    std::copy_n(work, block.size, x);
  }

  /// x := A⁻¹ x, in the original order. Allocates nothing.
  void solve(T* x) {
    const int n = size();
    for (int row = 0; row < n; ++row) work_[structure_.row_position[row]] = x[row];
    for (std::size_t b = 0; b < structure_.blocks.size(); ++b) {
      const BlockTriangular::Block& block = structure_.blocks[b];
      for (int i = block.begin; i < block.begin + block.size; ++i)
        for (int k = structure_.row_begin[i]; k < structure_.row_begin[i + 1]; ++k)
          work_[i] -= values_[structure_.diagonal_entries + k] * work_[structure_.column_index[k]];
      small_blocks::dispatch_by_size(block.size, [&](auto size) { solve_block<size>(block, row_exchanges_[b], x); });
    }
    for (int column = 0; column < n; ++column) x[column] = work_[structure_.column_position[column]];
  }

  /// x := A⁻ᵀ x.
  void solve_transposed(T* x) {
    const int n = size();
    for (int column = 0; column < n; ++column) work_[structure_.column_position[column]] = x[column];
    for (std::size_t b = structure_.blocks.size(); b-- > 0;) {
      const BlockTriangular::Block& block = structure_.blocks[b];
      small_blocks::dispatch_by_size(block.size,
                                     [&](auto size) { solve_block_transposed<size>(block, row_exchanges_[b], x); });
      for (int i = block.begin; i < block.begin + block.size; ++i)
        for (int k = structure_.row_begin[i]; k < structure_.row_begin[i + 1]; ++k)
          work_[structure_.column_index[k]] -= values_[structure_.diagonal_entries + k] * work_[i];
    }
    for (int row = 0; row < n; ++row) x[row] = work_[structure_.row_position[row]];
  }

 private:
  using Block = BlockTriangular::Block;
  using Exchanges = lane_blocks::RowExchanges<T>;

  void fill(const Block& block, const std::vector<int>& order, T* factors) const {
    for (int i = 0; i < block.size; ++i)
      for (int j = 0; j < block.size; ++j)
        factors[i * block.size + j] = values_[block.offset + (order[block.begin + i] - block.begin) * block.size + j];
  }

  template <int N>
  T factorise_block(const Block& block, Exchanges& exchanges) {
    T* factors = factors_.data() + block.offset;
    fill(block, pivot_order_, factors);
    if constexpr (N > 0 && N <= lane_blocks::max_inverted_size) {
      return lane_blocks::invert(std::integral_constant<int, N>{}, factors);
    } else {
      exchanges.clear();
      auto elimination = lane_blocks::eliminate<N>(factors, block.size);
      if (any(elimination.needs_pivoting)) {
        fill(block, pivot_order_, factors);
        elimination =
            lane_blocks::eliminate_with_pivoting<N>(factors, block.size, elimination.needs_pivoting, exchanges);
      }
      return elimination.min_pivot;
    }
  }

  template <int N>
  void solve_block(const Block& block, const Exchanges& exchanges, T* scratch) {
    const T* factors = factors_.data() + block.offset;
    T* work = &work_[block.begin];
    if constexpr (N > 0 && N <= lane_blocks::max_inverted_size) {
      lane_blocks::multiply<N>(factors, work);
    } else {
      for (int i = 0; i < block.size; ++i) scratch[i] = work_[pivot_order_[block.begin + i]];
      for (const auto& e : exchanges) lane_blocks::exchange(e.lanes, scratch[e.row], scratch[e.other]);
      lane_blocks::solve<N>(factors, block.size, scratch);
      for (int i = 0; i < block.size; ++i) work[i] = scratch[i];
    }
  }

  template <int N>
  void solve_block_transposed(const Block& block, const Exchanges& exchanges, T* scratch) {
    const T* factors = factors_.data() + block.offset;
    T* work = &work_[block.begin];
    if constexpr (N > 0 && N <= lane_blocks::max_inverted_size) {
      lane_blocks::multiply_transposed<N>(factors, work);
    } else {
      lane_blocks::solve_transposed<N>(factors, block.size, work);
      for (auto e = exchanges.rbegin(); e != exchanges.rend(); ++e)
        lane_blocks::exchange(e->lanes, work[e->row], work[e->other]);
      for (int i = 0; i < block.size; ++i) scratch[i] = work[i];
      for (int i = 0; i < block.size; ++i) work_[pivot_order_[block.begin + i]] = scratch[i];
    }
  }

  BlockTriangular scalar_;  ///< provides index()
  BlockTriangular::Structure structure_;
  std::vector<int> pivot_order_;          ///< per permuted row: the row at this position in its block's factors
  std::vector<T> values_, factors_;       ///< as in BlockTriangular
  std::vector<T> quality_;                ///< per block, from the last factorisation
  std::vector<Exchanges> row_exchanges_;  ///< per block
  std::vector<T> work_;
};

// The linear systems of foundation/numerics/square_system.hpp and foundation/numerics/overdetermined_system.hpp with
// one sample per lane.

/// Same interface as BlockTriangular. Results for all lanes together are those of the worst lane. store() stores the
/// matrix of the last lane, and is_near_stored() compares every lane with the previous one, the first lane with the
/// stored matrix.
template <int W>
class LaneSquareSystem {
 public:
  using T = Pack<W>;

  bool analyse(const SparsityPattern& pattern) {
    BlockTriangular scalar;
    if (!scalar.analyse(pattern)) return false;
    lanes_.emplace(scalar);
    diagonal_value_count_ = static_cast<std::size_t>(scalar.structure().diagonal_entries);
    stored_.assign(scalar.entry_count(), 0);
    difference_.assign(diagonal_value_count_, T(0.0));
    sums_.assign(static_cast<std::size_t>(scalar.size()), T(0.0));
    column_.assign(2 * sums_.size(), T(0.0));
    return true;
  }
  /// See LaneBlockTriangular::set_pivot_order().
  void take_order(const BlockTriangular& scalar) { lanes_->set_pivot_order(scalar); }

  int size() const { return lanes_->size(); }
  int index(int row, int column) const { return lanes_->index(row, column); }
  T* storage() { return lanes_->storage(); }
  const T* storage() const { return lanes_->storage(); }
  std::size_t stored() const { return stored_.size(); }
  T at(int row, int column) const {
    const int entry = index(row, column);
    return entry < 0 ? T(0.0) : storage()[entry];
  }

  double factorise() {
    quality_ = lanes_->factorise();
    return reduce_min(quality_);
  }
  /// Per lane, from the last factorisation.
  const T& min_pivot() const { return quality_; }

  void store() {
    for (std::size_t k = 0; k < diagonal_value_count_; ++k) stored_[k] = storage()[k][W - 1];
  }
  /// Stores a matrix of the same pattern in the layout of BlockTriangular.
  void store(const double* matrix) { std::copy_n(matrix, diagonal_value_count_, stored_.begin()); }
  bool is_near_stored(double limit) {
    for (std::size_t b = 0; b < lanes_->blocks().size(); ++b)
      if (!is_block_near_stored(b, limit)) return false;
    return true;
  }

  void solve(T* x) { lanes_->solve(x); }
  void solve_pair(T* x, T* z) {
    solve(x);
    solve(z);
  }
  void solve_transposed(T* x) { lanes_->solve_transposed(x); }

 private:
  /// As in BlockTriangular: the cheap bound first.
  bool is_block_near_stored(std::size_t b, double limit) {
    const BlockTriangular::Block& block = lanes_->blocks()[b];
    const int n = block.size;
    const T* current = lanes_->storage() + block.offset;
    const double* stored_block = stored_.data() + block.offset;
    T max_row_sum = 0.0;
    for (int i = 0, k = 0; i < n; ++i) {
      T sum = 0.0;
      for (int j = 0; j < n; ++j, ++k) {
        difference_[k] = current[k] - shift_lanes(current[k], stored_block[k]);
        sum += abs(difference_[k]);
      }
      max_row_sum = max(max_row_sum, sum);
    }
    if (all(4.0 * n * max_row_sum <= limit * lanes_->min_pivot(b))) return true;
    for (int i = 0; i < n; ++i) sums_[i] = 0.0;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) column_[i] = difference_[i * n + j];
      lanes_->solve_in_block(b, column_.data());
      for (int i = 0; i < n; ++i) sums_[i] += abs(column_[i]);
    }
    const auto within = [limit](const T& sum) { return all(sum <= limit); };  // false for NaN
    return std::all_of(sums_.begin(), sums_.begin() + n, within);
  }

  std::optional<LaneBlockTriangular<T>> lanes_;
  std::size_t diagonal_value_count_ = 0;  ///< number of entries in the diagonal blocks
  std::vector<double> stored_;
  std::vector<T> difference_, sums_, column_;  ///< for is_near_stored()
  T quality_ = 0.0;
};

template <int W>
struct SquareSystemOf<Pack<W>> {
  using Type = LaneSquareSystem<W>;
};

/// Not available in lanes: redundant constraints are solved one sample after another.
template <int W>
class OverdeterminedSystem<Pack<W>> {
 public:
  using T = Pack<W>;
  void resize(int, int) { throw_unsupported(); }
  T* storage() { return throw_unsupported(); }
  const T* storage() const { return throw_unsupported(); }
  const T& at(int, int) const { return *throw_unsupported(); }
  double factorise() { return throw_unsupported(), 0; }
  void keep() { throw_unsupported(); }
  bool near_kept(double) const { return throw_unsupported(), false; }
  void solve(T*) const { throw_unsupported(); }

 private:
  [[noreturn]] static T* throw_unsupported() { throw std::logic_error("redundant constraints have no lanes"); }
};

}  // namespace balance::numerics
