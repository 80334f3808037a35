#include "balance/base/factorizations.hpp"

template class Eigen::JacobiSVD<balance::MatrixX>;
