#pragma once
/// Square linear systems whose sparsity never changes, solved thousands of times: rows and columns are put once into block
/// lower triangular form, after which only the diagonal blocks are factorised and nothing else that is zero is stored. The legs of a
/// parallel robot separate, a chain of loops costs what its loops cost, in time and memory.

#include "balance/base/block_order.hpp"
#include "balance/base/small_blocks.hpp"

#include <vector>

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
  /// @return the smallest |pivot| or 1/|entry of an inverse|, 0 if singular; a measure of regularity for matrices with entries of the order of one
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
