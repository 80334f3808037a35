// How far the equations' matrix is from a singular one.

#include "balance/motion/equations.hpp"

namespace balance {

template <class S>
double Equations<S>::least_singular_value() {
  const int n = columns();
  if (!redundant_ && n > most_dense && factorise())
    if (const std::optional<double> value = least_singular_by_inverse(sparse_)) return *value;
  double* normal = least_singular_.normal(n);
  if (redundant_) {
    Eigen::Map<Samples>(normal, n, n).noalias() = dense_.transpose() * dense_;
    return least_singular_.of_normal();
  }
  sparse_.write_normal(normal);  // in the order of the storage, which changes no singular value
  if (factorised_ == filled_ && regularity_ > 0)
    if (const std::optional<double> value = least_singular_.of_factors(sparse_)) return *value;
  return least_singular_.of_normal();
}

template <class S>
double Equations<S>::distance_from_singular() const {
  if (!redundant_ && columns() > most_dense) {
    BlockTriangular factors = sparse_;
    if (factors.factorise() > 0)
      if (const std::optional<double> value = least_singular_by_inverse(factors)) return *value;
  }
  return smallest_singular_value(dense());
}

#define BALANCE_INSTANTIATE(S)                          \
  template double Equations<S>::least_singular_value(); \
  template double Equations<S>::distance_from_singular() const;
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
