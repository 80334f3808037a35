// How far the equations' matrix is from a singular one.

#include "balance/base/number.hpp"
#include "balance/motion/equations.hpp"

namespace balance {

template <class S>
typename S::Scalar Equations<S>::least_singular_value() {
  if constexpr (!std::is_same_v<T, double>) {  // dσ = uᵀ dA v
    const Eigen::JacobiSVD<MatrixX> svd(dense(), Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::Index last = svd.singularValues().size() - 1;
    T least = 0;
    for (int r = 0; r < rows(); ++r)
      for (int c = 0; c < columns(); ++c) least += svd.matrixU()(r, last) * svd.matrixV()(c, last) * entry(r, c);
    return least;
  } else {
    const int n = columns();
    if (!redundant_ && n > most_dense && factorise())
      if (const std::optional<double> value = least_singular_by_inverse(sparse_)) return *value;
    double* normal = least_singular_.normal(n);
    if (redundant_) {
      Eigen::Map<Samples>(normal, n, n).noalias() = tall_.dense().transpose() * tall_.dense();
      return least_singular_.of_normal();
    }
    sparse_.write_normal(normal);  // in the order of the storage, which changes no singular value
    if (factorised_ == filled_ && regularity_ > 0)
      if (const std::optional<double> value = least_singular_.of_factors(sparse_)) return *value;
    return least_singular_.of_normal();
  }
}

template <class S>
double Equations<S>::distance_from_singular() const {
  if (!redundant_ && columns() > most_dense) {
    SquareSystem<T> factors = sparse_;
    if (factors.factorise() > 0)
      if (const std::optional<double> value = least_singular_by_inverse(values_of(factors))) return *value;
  }
  return smallest_singular_value(dense());
}

template Number Equations<PlanarOf<Number>>::least_singular_value();
template Number Equations<SpatialOf<Number>>::least_singular_value();
template double Equations<PlanarOf<Number>>::distance_from_singular() const;
template double Equations<SpatialOf<Number>>::distance_from_singular() const;

}  // namespace balance
