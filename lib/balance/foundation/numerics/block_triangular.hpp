#pragma once
/// Square linear systems with a fixed sparsity pattern, solved thousands of times. Rows and columns are permuted once
/// to block lower triangular form. Only the diagonal blocks are factorised, and no zeros are stored outside them. The
/// legs of a parallel robot decouple, and a chain of loops costs the sum of its loops in time and memory.

#include "balance/foundation/base/dual.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

namespace balance::numerics {

// Block lower triangular form of a square sparse matrix: maximum matching, then strongly connected components (Duff &
// Reid, ACM TOMS 4, 1978).

/// Matrices with more columns than this are treated as sparse.
inline constexpr int max_dense_columns = 48;

/// Where a sparse matrix may be non-zero: the columns of each row, increasing.
using SparsityPattern = std::vector<std::vector<int>>;

/// Hash of a pattern (Fowler, Noll and Vo); always odd.
std::size_t hash_pattern(const SparsityPattern& pattern);

struct BlockTriangularForm {
  bool is_structurally_regular = false;  ///< some values make the matrix regular; else the lists below are empty
  std::vector<std::vector<int>>
      blocks;                       ///< rows of each diagonal block, increasing, in the order in which they are solved
  std::vector<int> matched_column;  ///< per row: the column matched to it, in the same block
};

/// @param pattern of a square matrix
BlockTriangularForm find_block_triangular_form(const SparsityPattern& pattern);

}  // namespace balance::numerics

namespace balance::numerics::small_blocks {

// Factorisation and solution of the small dense blocks that the sparse systems of mechanisms decompose into. Row-major
// storage.

/// LU factorisation in place with row exchanges; the diagonal holds the reciprocals of the pivots. N is the size if it
/// is known at compile time, else 0: the blocks of most mechanisms are so small that loops would cost more than the
/// arithmetic.
/// @return the smallest |pivot|, 0 if singular
template <int N>
double factorise_block(double* a, int* pivots, int size) {
  const int n = N > 0 ? N : size;
  double min_pivot = INFINITY;
  for (int k = 0; k < n; ++k) {
    int pivot_row = k;
    double pivot_magnitude = std::abs(a[k * n + k]);
    for (int i = k + 1; i < n; ++i)
      if (std::abs(a[i * n + k]) > pivot_magnitude) pivot_magnitude = std::abs(a[i * n + k]), pivot_row = i;
    pivots[k] = pivot_row;
    if (pivot_row != k)
      for (int j = 0; j < n; ++j) std::swap(a[k * n + j], a[pivot_row * n + j]);
    min_pivot = std::min(min_pivot, pivot_magnitude);
    if (!(pivot_magnitude > 0)) return 0;
    const double inverse = 1 / a[k * n + k];
    a[k * n + k] = inverse;
    for (int i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] *= inverse;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return min_pivot;
}

// x −= a y and x *= a, for numbers, duals and pairs of numbers.
inline void subtract(double& x, double a, double y) { x -= a * y; }
inline void scale(double& x, double a) { x *= a; }
template <int N>
void subtract(Dual<N>& x, double a, const Dual<N>& y) {
  x.value -= a * y.value;
  x.d -= a * y.d;
}
template <int N>
void scale(Dual<N>& x, double a) {
  x *= a;
}
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

/// Keeps the unknowns of a small block in registers. X: a number or several.
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

/// Largest block that is inverted by cofactors: one division instead of a chain of them, and independent products.
inline constexpr int max_inverted_size = 3;

/// Divides the cofactors by the determinant. @return 1/|largest entry of the inverse|, at most the smallest singular
/// value times the size; 0 if singular
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

/// Calls `work` with the size as a compile-time constant if it is small, else with 0.
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

}  // namespace balance::numerics::small_blocks

namespace balance::numerics {

class BlockTriangular {
 public:
  BlockTriangular() = default;

  /// @param pattern entries that may ever be non-zero
  /// @return false if no choice of values makes the matrix regular (structurally singular)
  bool analyse(const SparsityPattern& pattern);

  int size() const { return static_cast<int>(row_position_.size()); }

  /// Entry (row, column), inside the pattern; set before factorise().
  double& at(int row, int column) { return values_[index(row, column)]; }
  /// Zero outside the pattern.
  double at(int row, int column) const {
    const int entry = index(row, column);
    return entry < 0 ? 0 : values_[entry];
  }
  /// Index of an entry in storage(), to avoid the look-up in hot loops; negative outside the pattern.
  int index(int row, int column) const;
  double* storage() { return values_.data(); }
  const double* storage() const { return values_.data(); }
  /// Number of stored entries.
  std::size_t entry_count() const { return values_.size(); }
  /// AᵀA with permuted rows and columns: the upper triangle, row-major, n×n, zeros below.
  void write_normal_matrix(double* normal) const;

  struct Block {
    int begin, size, offset;  ///< first row, number of rows, offset of its factors
    double min_pivot;         ///< smallest |pivot| of the last factorisation
  };
  /// Result of the analysis, and the row exchanges of the last factorisation in blocks of more than `max_inverted_size`
  /// rows: for each permuted row in turn, the row of the block that it is exchanged with.
  struct Structure {
    std::vector<int> row_position, column_position;  ///< of the original rows and columns in the permuted matrix
    std::vector<Block> blocks;
    std::vector<int> row_begin,
        column_index;      ///< CSR form of the entries left of the diagonal blocks, by permuted rows and columns
    int diagonal_entries;  ///< number of entries in the diagonal blocks, which are stored first
    std::vector<int> row_exchanges;
  };
  Structure structure() const {
    return {row_position_, column_position_, blocks_, row_begin_, column_index_, diagonal_value_count_, pivots_};
  }

  /// Factorises the diagonal blocks: inverses of small ones, LU with partial pivoting of the others.
  /// @return the smallest |pivot| or 1/|entry of an inverse|, at most 1; 0 if singular. It measures the regularity of
  /// matrices with entries of order one.
  double factorise();

  /// Stores the matrix last factorised for is_near_stored().
  void store();
  /// Whether every matrix on the line segment from the stored matrix K to the one last factorised, A, is regular by a
  /// margin: ‖A⁻¹ (A − K)‖ ≤ limit < 1 in every diagonal block (maximum row sum). Allocates nothing.
  bool is_near_stored(double limit);

  /// x := A⁻¹ x, both in the original order. Allocates nothing.
  void solve(double* x) { solve(x, work_.data()); }
  /// x := A⁻¹ x and z := A⁻¹ z in one pass.
  void solve_pair(double* x, double* z);
  /// x := A⁻ᵀ x.
  void solve_transposed(double* x) { solve_transposed(x, work_.data()); }
  /// The same for any type with subtract() and scale() in small_blocks: several right-hand sides in one pass.
  /// @param work one entry per unknown
  template <class X>
  void solve(X* x, X* work) const;
  template <class X>
  void solve_transposed(X* x, X* work) const;

 private:
  /// Forward substitution over the blocks, in the permuted order, for all right-hand sides in X.
  template <class X>
  void substitute(X* work) const;
  /// x := A_bb⁻¹ x for a diagonal block.
  template <class X>
  void solve_block(const Block& block, X* x) const;
  bool is_block_near_stored(const Block& block, double limit);

  std::vector<int> row_position_, column_position_;  ///< of the original rows and columns in the permuted matrix
  std::vector<Block> blocks_;
  std::vector<int> block_at_;      ///< block of each permuted row
  std::vector<int> row_begin_;     ///< per permuted row: first of its entries left of the diagonal block; and the end
  std::vector<int> column_index_;  ///< permuted columns of these entries
  std::vector<double> values_;     ///< the diagonal blocks, row-major and consecutive, then the entries left of them
  int diagonal_value_count_ = 0;   ///< number of values in the diagonal blocks
  std::vector<double> factors_;    ///< factors of the diagonal blocks, in the same order
  std::vector<double> stored_;     ///< the diagonal blocks at the last store()
  std::vector<int> pivots_;        ///< row exchanges, one per permuted row
  struct Pair {
    double x, z;
  };

  std::vector<double> work_, sums_;
  std::vector<Pair> pairs_;
};

template <class X>
void BlockTriangular::solve_block(const Block& block, X* x) const {
  using namespace small_blocks;
  dispatch_by_size(block.size, [&](auto block_size) {
    const double* factors = factors_.data() + block.offset;
    if constexpr (block_size > 0 && block_size <= max_inverted_size)
      multiply<block_size>(factors, x);
    else
      small_blocks::solve_block<block_size>(factors, &pivots_[block.begin], block.size, x);
  });
}

template <class X>
void BlockTriangular::substitute(X* work) const {
  using small_blocks::subtract;
  const double* values = values_.data() + diagonal_value_count_;
  for (const Block& block : blocks_) {
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      X sum = work[i];
      for (int k = row_begin_[i]; k < row_begin_[i + 1]; ++k) subtract(sum, values[k], work[column_index_[k]]);
      work[i] = sum;
    }
    solve_block(block, work + block.begin);
  }
}

template <class X>
void BlockTriangular::solve(X* x, X* work) const {
  const int n = size();
  for (int row = 0; row < n; ++row) work[row_position_[row]] = x[row];
  substitute(work);
  for (int column = 0; column < n; ++column) x[column] = work[column_position_[column]];
}

template <class X>
void BlockTriangular::solve_transposed(X* x, X* work) const {
  using namespace small_blocks;
  const int n = size();
  const double* values = values_.data() + diagonal_value_count_;
  for (int column = 0; column < n; ++column) work[column_position_[column]] = x[column];
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    dispatch_by_size(block->size, [&](auto block_size) {
      const double* factors = factors_.data() + block->offset;
      if constexpr (block_size > 0 && block_size <= max_inverted_size)
        multiply_transposed<block_size>(factors, work + block->begin);
      else
        solve_block_transposed<block_size>(factors, &pivots_[block->begin], block->size, work + block->begin);
    });
    for (int i = block->begin; i < block->begin + block->size; ++i)
      for (int k = row_begin_[i]; k < row_begin_[i + 1]; ++k) subtract(work[column_index_[k]], values[k], work[i]);
  }
  for (int row = 0; row < n; ++row) x[row] = work[row_position_[row]];
}

}  // namespace balance::numerics
