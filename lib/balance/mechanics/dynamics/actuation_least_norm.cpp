#include "balance/mechanics/dynamics/actuation.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/regularity.hpp"

#include <algorithm>

namespace balance::dynamics {

ActuationFactors::ActuationFactors(const MatrixX& C, const MatrixX& S, int freedoms)
    : null_space(MatrixX::Identity(S.cols(), S.cols())), has_closures(C.rows() > 0) {
  if (has_closures) {
    closures.compute(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
    null_space = closures.matrixV().rightCols(freedoms);
  }
  selection.compute(null_space.transpose() * S.transpose(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorX& sigma = selection.singularValues();
  if (freedoms > 0)
    is_regular = sigma.size() >= freedoms &&
                 sigma[freedoms - 1] >= numerics::singular_pivot_threshold * std::max(1e-300, sigma[0]);
  const Eigen::Index rank = S.cols() - freedoms;
  if (has_closures && rank > 0 && rank <= closures.singularValues().size())
    is_regular = is_regular && closures.singularValues()[rank - 1] >=
                                   numerics::singular_pivot_threshold * closures.singularValues()[0];
}

LeastNormSolution solve_least_norm(const ActuationFactors& factors, const MatrixX& S, const VectorX& f) {
  const Eigen::Index freedoms = factors.null_space.cols(), rank = S.cols() - freedoms;
  LeastNormSolution solution{VectorX::Zero(S.rows()), {}};
  if (freedoms > 0) solution.efforts = factors.selection.solve(factors.null_space.transpose() * f);
  if (!factors.has_closures) return solution;
  // only the singular directions within the rank
  const auto& svd = factors.closures;
  const VectorX residual = svd.matrixV().leftCols(rank).transpose() * (f - S.transpose() * solution.efforts);
  solution.multipliers = svd.matrixU().leftCols(rank) * residual.cwiseQuotient(svd.singularValues().head(rank));
  return solution;
}

LeastNormSolution differentiate_least_norm(const ActuationFactors& factors, const LeastNormSolution& solution,
                                           const MatrixX& C, const MatrixX& S, const MatrixX& dC, const MatrixX& dS,
                                           const VectorX& df) {
  const Eigen::Index columns = S.cols(), closures = C.rows();
  const MatrixX& N = factors.null_space;
  const VectorX n = N.cols() > 0 ? VectorX(N * numerics::CompleteOrthogonalDecomposition(S * N).solve(solution.efforts))
                                 : VectorX(VectorX::Zero(columns));
  const VectorX v = closures > 0 ? VectorX(numerics::CompleteOrthogonalDecomposition(C).solve(solution.multipliers))
                                 : VectorX(VectorX::Zero(columns));
  MatrixX system = MatrixX::Zero(columns + closures, 2 * columns);
  system.topLeftCorner(columns, columns) = S.transpose() * S;
  system.topRightCorner(columns, columns) = C.transpose() * C;
  system.bottomLeftCorner(closures, columns) = C;
  VectorX rhs(columns + closures);
  rhs.head(columns) =
      df - dS.transpose() * (S * n) - S.transpose() * (dS * n) - dC.transpose() * (C * v) - C.transpose() * (dC * v);
  rhs.tail(closures) = -dC * n;
  const VectorX change = numerics::CompleteOrthogonalDecomposition(system).solve(rhs);
  return {dS * n + S * change.head(columns), dC * v + C * change.tail(columns)};
}

}  // namespace balance::dynamics
