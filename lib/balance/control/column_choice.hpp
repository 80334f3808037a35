#pragma once
/// Columns of a matrix that determine the others, by QR decompositions with column pivoting (Businger and Golub, Numer. Math. 7,
/// 1965). Private to control.

#include "balance/base/types.hpp"

#include <vector>

namespace balance {

double compute_reciprocal_condition(const MatrixX& matrix);  ///< singular values
MatrixX select_columns(const MatrixX& matrix, const std::vector<int>& columns);
std::vector<int> complement_indices(const std::vector<int>& some, int n);  ///< of 0 … n − 1

/// The first `count` pivots, in the order of the columns. @param last the last pivot against the first
std::vector<int> pivot_columns(const MatrixX& matrix, int count, double& last);

/// The same, columns of joints that stick only where the others do not suffice: then all that can move while these joints
/// stick moves with the independent columns that are not theirs.
std::vector<int> pivot_moving_columns(const MatrixX& matrix, int count, const std::vector<bool>& stuck);

}  // namespace balance
