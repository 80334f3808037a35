#pragma once
/// Square linear systems whose sparsity never changes, solved thousands of times: rows and columns are put once into block
/// lower triangular form, after which only the diagonal blocks are factorised and nothing else that is zero is stored. The legs of a
/// parallel robot separate, a chain of loops costs what its loops cost, in time and memory.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

namespace balance {

// Block lower triangular form of a square sparse matrix: maximum matching, then strongly connected components (Duff & Reid, ACM
// TOMS 4, 1978).

/// Matrices with more columns than this are treated as sparse ones.
inline constexpr int max_dense_columns = 48;

/// Where a sparse matrix may be non-zero: per row its columns, increasing.
using SparsityPattern = std::vector<std::vector<int>>;

/// Odd, and not the same where patterns differ (Fowler, Noll and Vo's hash).
std::size_t hash_pattern(const SparsityPattern& pattern);

struct BlockTriangularForm {
  bool is_structurally_regular = false;  ///< some choice of values makes the matrix regular; else there is no order
  std::vector<std::vector<int>>
      blocks;                       ///< rows of each diagonal block, increasing, in the order in which they are solved
  std::vector<int> matched_column;  ///< per row: the column matched to it, in the same block
};

/// @param pattern of a square matrix
BlockTriangularForm find_block_triangular_form(const SparsityPattern& pattern);

}  // namespace balance

namespace balance::small_blocks {

// Factorisation and solution of the small dense blocks that sparse systems of mechanisms fall apart into. Row-major storage.

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

// x −= a y and x *= a, for numbers and for pairs of them; for duals: foundation/numerics/square_system.hpp.
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

namespace balance {

class BlockTriangular {
 public:
  BlockTriangular() = default;

  /// @param pattern where an entry may ever be non-zero
  /// @return false if no choice of values makes the matrix regular (structurally singular)
  bool analyse(const SparsityPattern& pattern);

  int size() const { return static_cast<int>(row_position_.size()); }

  /// Entry (row, column) of the matrix, inside the pattern, to be written before factorise().
  double& at(int row, int column) { return values_[index(row, column)]; }
  /// Zero outside the pattern.
  double at(int row, int column) const {
    const int place = index(row, column);
    return place < 0 ? 0 : values_[place];
  }
  /// The place of an entry in storage(), which saves the look-up in a hot loop; negative outside the pattern.
  int index(int row, int column) const;
  double* storage() { return values_.data(); }
  const double* storage() const { return values_.data(); }
  /// How many entries have a place.
  std::size_t entry_count() const { return values_.size(); }
  /// AᵀA with its rows and columns in another order: the upper triangle, row-major, n×n, zeros below.
  void write_normal_matrix(double* normal) const;

  struct Block {
    int begin, size, offset;  ///< first row, rows, where its factors start
    double min_pivot;         ///< smallest |pivot| of the last factorisation
  };
  /// What the analysis found, and the exchanges of rows that the last factorisation of blocks above `max_inverted_size` rows made:
  /// per permuted row, in turn, the row of the block that it is exchanged with.
  struct Structure {
    std::vector<int> row_position, column_position;  ///< of an original row or column in the permuted matrix
    std::vector<Block> blocks;
    std::vector<int> row_begin,
        column_index;      ///< per permuted row: its entries left of the diagonal block, in columns; and the end
    int diagonal_entries;  ///< entries of the diagonal blocks, stored before those
    std::vector<int> row_exchanges;
  };
  Structure structure() const { return {row_position_, column_position_, blocks_, start_, columns_, inside_, pivots_}; }

  /// The diagonal blocks: inverses of the smallest, LU with partial pivoting of the others.
  /// @return the smallest |pivot| or 1/|entry of an inverse|, 0 if singular; a measure of regularity for matrices with entries of the order
  /// of one
  double factorise();

  /// Remembers the matrix last factorised for near_kept().
  void store();
  /// Whether every matrix on the straight way from the kept one K to the one last factorised, A, is regular by a margin: in every
  /// diagonal block ‖A⁻¹ (A − K)‖ ≤ limit < 1 (largest sum along a row). Allocates nothing.
  bool is_near_stored(double limit);

  /// x := A⁻¹ x, both in the original order. Allocates nothing.
  void solve(double* x) { solve(x, work_.data()); }
  /// Both x := A⁻¹ x and z := A⁻¹ z, in one go.
  void solve_pair(double* x, double* z);
  /// x := A⁻ᵀ x.
  void solve_transposed(double* x) { solve_transposed(x, work_.data()); }
  /// The same for whatever small_blocks can subtract() and scale(): several right-hand sides in one go.
  /// @param work as many as unknowns
  template <class X>
  void solve(X* x, X* work) const;
  template <class X>
  void solve_transposed(X* x, X* work) const;

 private:
  /// Forward substitution over the blocks, in the permuted order, of one or two right-hand sides.
  template <class X>
  void substitute(X* work) const;
  /// x := A_bb⁻¹ x for a diagonal block.
  template <class X>
  void solve_block(const Block& block, X* x) const;
  bool is_block_near_stored(const Block& block, double limit);

  std::vector<int> row_position_, column_position_;  ///< of an original row or column in the permuted matrix
  std::vector<Block> blocks_;
  std::vector<int> block_at_;    ///< per permuted row
  std::vector<int> start_;       ///< per permuted row: its entries left of the diagonal block, in columns_; and the end
  std::vector<int> columns_;     ///< of these entries, permuted
  std::vector<double> values_;   ///< the diagonal blocks, row-major one after another, then the entries left of them
  int inside_ = 0;               ///< how many values the diagonal blocks have
  std::vector<double> factors_;  ///< of the diagonal blocks, in the same order
  std::vector<double> stored_;   ///< the diagonal blocks of an earlier matrix
  std::vector<int> pivots_;      ///< row exchanges, per permuted row
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
  const double* values = values_.data() + inside_;
  for (const Block& block : blocks_) {
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      X sum = work[i];
      for (int k = start_[i]; k < start_[i + 1]; ++k) subtract(sum, values[k], work[columns_[k]]);
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
  const double* values = values_.data() + inside_;
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
      for (int k = start_[i]; k < start_[i + 1]; ++k) subtract(work[columns_[k]], values[k], work[i]);
  }
  for (int row = 0; row < n; ++row) x[row] = work[row_position_[row]];
}

}  // namespace balance
