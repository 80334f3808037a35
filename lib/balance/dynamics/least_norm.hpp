#pragma once
/// Efforts of least norm and, under them, multipliers of least norm, where actuators or closures are more than needed:
/// Sᵀ u + Cᵀ λ = f. Private to dynamics.

#include "balance/base/dual.hpp"
#include "balance/base/factorizations.hpp"

namespace balance {

// ---- matrices over numbers with derivatives ----

template <class T, int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> values_of(const Eigen::Matrix<T, Rows, Columns>& matrix) {
  return matrix.unaryExpr([](const T& x) { return value_of(x); });
}

/// Derivatives with respect to number k.
template <int N, int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> derivatives_of(const Eigen::Matrix<Dual<N>, Rows, Columns>& matrix,
                                                    std::size_t k) {
  return matrix.unaryExpr([k](const Dual<N>& x) { return x.d[k]; });
}

/// What efforts can do to the velocities that the loops allow.
struct ActuationFactors {
  MatrixX null_space;                              ///< of the closures: columns × freedoms
  SingularValueDecomposition closures, selection;  ///< the first computed only where there are closures
  bool has_closures = false;
  bool is_regular = true;  ///< the actuators hold the mechanism, and the loops keep their rank

  /// @param C closures × columns, scaled @param S actuators × columns, scaled
  ActuationFactors(const MatrixX& C, const MatrixX& S, int freedoms);
};

struct LeastNormSolution {
  VectorX efforts, multipliers;
};

/// @param f generalised forces, scaled
LeastNormSolution solve_least_norm(const ActuationFactors& factors, const MatrixX& S, const VectorX& f);

/// Its derivative with respect to one number, on which C, S and f depend; the rank of C does not change with it. With n a velocity that
/// the loops allow, u = S n, and λ = C v, the solution is that of Sᵀ S n + Cᵀ C v = f, C n = 0, which is differentiated.
LeastNormSolution differentiate_least_norm(const ActuationFactors& factors, const LeastNormSolution& solution,
                                           const MatrixX& C, const MatrixX& S, const MatrixX& dC, const MatrixX& dS,
                                           const VectorX& df);

}  // namespace balance
