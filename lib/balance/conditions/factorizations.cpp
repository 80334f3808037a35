#include "balance/base/factorizations.hpp"

template class Eigen::BDCSVD<balance::MatrixX>;
template class Eigen::LDLT<balance::MatrixX>;
