#include "balance/conditions/farkas.hpp"
#include "balance/conditions/linear_program.hpp"

namespace balance {

std::optional<VectorX> find_bounds_certificate(const VectorX& constant, const MatrixX& gradient, const VectorX& lower,
                                               const VectorX& upper) {
  const Eigen::Index n = gradient.rows(), z = gradient.cols();
  // Unknowns: λ⁺, λ⁻ and the rates of the left-hand side split into rises and falls, gᵀ = λᵀ gradient = rise − fall. Where it
  // rises with z its least value is at the lower bound.
  LinearProgram program(2 * n + 2 * z);
  program.lower.setZero();
  program.cost.head(2 * n).setOnes();
  VectorX least(2 * n + 2 * z);
  least << constant, -constant, lower, -upper;
  for (Eigen::Index j = 0; j < z; ++j) {
    VectorX rate = VectorX::Zero(2 * n + 2 * z);
    rate.head(n) = gradient.col(j);
    rate.segment(n, n) = -gradient.col(j);
    rate[2 * n + j] = -1;
    rate[2 * n + z + j] = 1;
    program.add_row(0, rate, 0);
    if (lower[j] == -no_bound) program.upper[2 * n + j] = least[2 * n + j] = 0;
    if (upper[j] == no_bound) program.upper[2 * n + z + j] = least[2 * n + z + j] = 0;
  }
  program.add_row(1, least, no_bound);
  const LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status != LinearProgramStatus::optimal) return std::nullopt;
  return solution.x.head(n) - solution.x.segment(n, n);
}

}  // namespace balance
