#pragma once
/// Eigen's factorizations of the library's dense matrices, compiled once: each takes the compiler seconds. Those that conditions,
/// design and control alone ask for are compiled with conditions.

#include "balance/base/types.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

extern template class Eigen::ColPivHouseholderQR<balance::MatrixX>;
extern template class Eigen::CompleteOrthogonalDecomposition<balance::MatrixX>;
extern template class Eigen::FullPivLU<balance::MatrixX>;
extern template class Eigen::HouseholderQR<balance::MatrixX>;
extern template class Eigen::JacobiSVD<balance::MatrixX>;
extern template class Eigen::LLT<balance::MatrixX>;
extern template class Eigen::PartialPivLU<balance::MatrixX>;
extern template class Eigen::SelfAdjointEigenSolver<balance::Matrix3>;
extern template class Eigen::SelfAdjointEigenSolver<balance::MatrixX>;

// conditions/factorizations.cpp
extern template class Eigen::BDCSVD<balance::MatrixX>;
extern template class Eigen::LDLT<balance::MatrixX>;
