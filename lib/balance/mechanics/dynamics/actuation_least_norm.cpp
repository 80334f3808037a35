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
  LeastNormSolution solution{VectorX::Zero(S.rows()), {}};
  if (factors.null_space.cols() > 0) solution.efforts = factors.selection.solve(factors.null_space.transpose() * f);
  solution.multipliers = solve_multipliers(factors, S, f, solution.efforts);
  return solution;
}

VectorX solve_multipliers(const ActuationFactors& factors, const MatrixX& S, const VectorX& f, const VectorX& efforts) {
  if (!factors.has_closures) return {};
  // only the singular directions within the rank
  const Eigen::Index rank = S.cols() - factors.null_space.cols();
  const auto& svd = factors.closures;
  const VectorX residual = svd.matrixV().leftCols(rank).transpose() * (f - S.transpose() * efforts);
  return svd.matrixU().leftCols(rank) * residual.cwiseQuotient(svd.singularValues().head(rank));
}

namespace {

/// n and μ with u = S n + Eᵀ μ, qᵀ μ = 0 and pᵀ μ = 0.
struct EffortMultipliers {
  VectorX n, mu;
};

EffortMultipliers find_effort_multipliers(const MatrixX& N, const MatrixX& S, const VectorX& efforts,
                                          const std::vector<ActiveBoundChange>& active, double excess) {
  const Eigen::Index freedoms = N.cols(), count = static_cast<Eigen::Index>(active.size()), motors = S.rows();
  if (count == 0)
    return {freedoms > 0 ? VectorX(N * numerics::CompleteOrthogonalDecomposition(S * N).solve(efforts))
                         : VectorX(VectorX::Zero(S.cols())),
            VectorX()};
  MatrixX system = MatrixX::Zero(motors + 2, freedoms + count);
  system.topLeftCorner(motors, freedoms) = S * N;
  for (Eigen::Index j = 0; j < count; ++j) {
    const ActiveBoundChange& bound = active[static_cast<std::size_t>(j)];
    system(bound.actuator, freedoms + j) = 1;
    system(motors, freedoms + j) = excess > 0 ? bound.excess_share : 0;
    system(motors + 1, freedoms + j) = bound.peak_share;
  }
  VectorX rhs = VectorX::Zero(motors + 2);
  rhs.head(motors) = efforts;
  const VectorX solution = numerics::CompleteOrthogonalDecomposition(system).solve(rhs);
  return {N * solution.head(freedoms), solution.tail(count)};
}

}  // namespace

LeastNormSolution differentiate_least_norm(const ActuationFactors& factors, const LeastNormSolution& solution,
                                           const MatrixX& C, const MatrixX& S, const MatrixX& dC, const MatrixX& dS,
                                           const VectorX& df, const std::vector<ActiveBoundChange>& active,
                                           double excess) {
  const Eigen::Index columns = S.cols(), closures = C.rows(), count = static_cast<Eigen::Index>(active.size());
  const auto [n, mu] = find_effort_multipliers(factors.null_space, S, solution.efforts, active, excess);
  const VectorX v = closures > 0 ? VectorX(numerics::CompleteOrthogonalDecomposition(C).solve(solution.multipliers))
                                 : VectorX(VectorX::Zero(columns));
  const Eigen::Index extra = count > 0 ? count + 2 : 0;  // changes of μ, e and t, and as many equations
  MatrixX system = MatrixX::Zero(columns + closures + extra, 2 * columns + extra);
  system.topLeftCorner(columns, columns) = S.transpose() * S;
  system.block(0, columns, columns, columns) = C.transpose() * C;
  system.block(columns, 0, closures, columns) = C;
  VectorX rhs = VectorX::Zero(columns + closures + extra), efforts = S * n;
  for (Eigen::Index j = 0; j < count; ++j) efforts[active[static_cast<std::size_t>(j)].actuator] += mu[j];
  rhs.head(columns) =
      df - dS.transpose() * efforts - S.transpose() * (dS * n) - dC.transpose() * (C * v) - C.transpose() * (dC * v);
  rhs.segment(columns, closures) = -dC * n;
  const Eigen::Index row = columns + closures, column = 2 * columns;
  for (Eigen::Index j = 0; j < count; ++j) {
    const ActiveBoundChange& bound = active[static_cast<std::size_t>(j)];
    const double excess_share = excess > 0 ? bound.excess_share : 0;
    system.block(0, column + j, columns, 1) = S.row(bound.actuator).transpose();
    system.block(row + j, 0, 1, columns) = S.row(bound.actuator);
    for (Eigen::Index i = 0; i < count; ++i)
      if (active[static_cast<std::size_t>(i)].actuator == bound.actuator) system(row + j, column + i) = 1;
    system(row + j, column + count) = system(row + count, column + j) = -excess_share;
    system(row + j, column + count + 1) = system(row + count + 1, column + j) = -bound.peak_share;
    if (excess_share != 0) {
      rhs[row + count] += bound.excess_share_change * mu[j];
      rhs[row + j] = bound.excess_share_change * excess;
    }
    rhs[row + j] += bound.bound_change - dS.row(bound.actuator).dot(n);
  }
  const VectorX change = numerics::CompleteOrthogonalDecomposition(system).solve(rhs);
  VectorX effort_change = dS * n + S * change.head(columns);
  for (Eigen::Index j = 0; j < count; ++j)
    effort_change[active[static_cast<std::size_t>(j)].actuator] += change[column + j];
  return {effort_change, dC * v + C * change.segment(columns, columns)};
}

}  // namespace balance::dynamics
