#pragma once
/// Block lower triangular form of a square sparse matrix: maximum matching, then strongly connected components (Duff & Reid, ACM
/// TOMS 4, 1978). Private to base.

#include <cstddef>
#include <vector>

namespace balance {

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
