#pragma once
/// Sparsity patterns of small matrices.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"

/// Where a matrix of zeros and others is not zero.
inline balance::numerics::SparsityPattern places(const Eigen::MatrixXi& nonzero) {
  balance::numerics::SparsityPattern pattern(static_cast<std::size_t>(nonzero.rows()));
  for (int i = 0; i < nonzero.rows(); ++i)
    for (int j = 0; j < nonzero.cols(); ++j)
      if (nonzero(i, j)) pattern[static_cast<std::size_t>(i)].push_back(j);
  return pattern;
}
