#pragma once
/// Square linear systems whose sparsity never changes, solved thousands of times: rows and columns are put once into block
/// lower triangular form (maximum matching, then strongly connected components: Duff & Reid, ACM TOMS 4, 1978), after which
/// only the diagonal blocks are factorised. The legs of a parallel robot separate, a chain of loops costs what its loops cost.

#include "balance/base/types.hpp"

#include <vector>

namespace balance {

class BlockTriangular {
 public:
  BlockTriangular() = default;

  /// @param pattern n×n, non-zero where an entry may ever be non-zero
  /// @return false if no choice of values makes the matrix regular (structurally singular)
  bool analyse(const Eigen::MatrixXi& pattern);

  int size() const { return static_cast<int>(row_position_.size()); }

  /// Entry (row, column) of the matrix, to be written before factorise(). Entries outside the pattern stay zero.
  double& at(int row, int column) { return values_[row_position_[row] * size() + column_position_[column]]; }
  double at(int row, int column) const { return values_[row_position_[row] * size() + column_position_[column]]; }
  /// The place of an entry in storage(), which saves two look-ups in a hot loop.
  int index(int row, int column) const { return row_position_[row] * size() + column_position_[column]; }
  double* storage() { return values_.data(); }

  struct Block {
    int begin, size, offset;  ///< first row, rows, where its factors start
    double quality;           ///< smallest |pivot| of the last factorisation
  };
  /// What the analysis found, and the exchanges of rows that the last factorisation of blocks above `inverted` rows made:
  /// per permuted row, in turn, the row of the block that it is exchanged with.
  struct Structure {
    std::vector<int> row_position, column_position;  ///< of an original row or column in the permuted matrix
    std::vector<int> first;                          ///< per permuted row: its first column that may be non-zero
    std::vector<Block> blocks;
    std::vector<int> exchanges;
  };
  Structure structure() const { return {row_position_, column_position_, first_, blocks_, pivots_}; }

  /// The diagonal blocks: inverses of the smallest, LU with partial pivoting of the others.
  /// @return the smallest |pivot| or 1/|entry of an inverse|, 0 if singular; a measure of regularity for matrices with entries of the order of one
  double factorise();

  /// Remembers the matrix last factorised for near_kept().
  void keep();
  /// Whether every matrix on the straight way from the kept one K to the one last factorised, A, is regular by a margin: in every
  /// diagonal block ‖A⁻¹ (A − K)‖ ≤ limit < 1 (largest sum along a row). Allocates nothing.
  bool near_kept(double limit);

  /// x := A⁻¹ x, both in the original order. Allocates nothing.
  void solve(double* x);
  /// Both x := A⁻¹ x and z := A⁻¹ z, in one go.
  void solve_pair(double* x, double* z);
  /// x := A⁻ᵀ x.
  void solve_transposed(double* x);

 private:
  /// Forward substitution over the blocks, in the permuted order, of one or two right-hand sides.
  template <class X>
  void substitute(X* work) const;
  /// x := A_bb⁻¹ x for a diagonal block.
  template <class X>
  void solve_block(const Block& block, X* x) const;
  bool block_near_kept(const Block& block, double limit);

  std::vector<int> row_position_, column_position_;  ///< of an original row or column in the permuted matrix
  std::vector<int> first_;                           ///< per permuted row: its first column that may be non-zero
  std::vector<Block> blocks_;
  std::vector<double> values_;   ///< permuted matrix, row-major
  std::vector<double> factors_;  ///< of the diagonal blocks, row-major one after another
  std::vector<double> kept_;     ///< the diagonal blocks of an earlier matrix, in the same order
  std::vector<int> pivots_;      ///< row exchanges, per permuted row
  struct Pair {
    double x, z;
  };

  std::vector<double> work_, sums_;
  std::vector<Pair> pairs_;
};

}  // namespace balance
