#pragma once
/// Singular values and right singular vectors that can be relied upon.

#include "balance/foundation/base/types.hpp"

namespace balance {

struct RightSingularVectors {
  VectorX values;   ///< decreasing, as many as the smaller of the matrix's two sizes
  MatrixX vectors;  ///< columns × values
};

/// By divide and conquer, checked: Eigen's sometimes leaves entries that were never set. Then by Jacobi's method, which is slower.
RightSingularVectors compute_right_singular_vectors(const MatrixX& matrix);

}  // namespace balance
