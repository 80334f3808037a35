#include "balance/base/factorizations.hpp"

template class Eigen::ColPivHouseholderQR<balance::MatrixX>;
template class Eigen::CompleteOrthogonalDecomposition<balance::MatrixX>;
template class Eigen::FullPivLU<balance::MatrixX>;
template class Eigen::HouseholderQR<balance::MatrixX>;
template class Eigen::LLT<balance::MatrixX>;
template class Eigen::PartialPivLU<balance::MatrixX>;
template class Eigen::SelfAdjointEigenSolver<balance::Matrix3>;
template class Eigen::SelfAdjointEigenSolver<balance::MatrixX>;
