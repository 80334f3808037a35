#pragma once
/// Reliable singular values and right singular vectors.

#include "balance/foundation/base/types.hpp"

namespace balance::numerics {

struct RightSingularVectors {
  VectorX values;   ///< decreasing, min(rows, columns) of them
  MatrixX vectors;  ///< columns × values
};

/// Divide and conquer with a check of the result, because Eigen's sometimes leaves entries unset. Otherwise Jacobi's
/// method, which is slower.
RightSingularVectors compute_right_singular_vectors(const MatrixX& matrix);

}  // namespace balance::numerics
