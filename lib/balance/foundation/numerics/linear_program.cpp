#include "balance/foundation/numerics/linear_program.hpp"

#include <ClpSimplex.hpp>

#include <algorithm>
#include <vector>

namespace balance {

LinearProgram::LinearProgram(Eigen::Index n)
    : cost(VectorX::Zero(n)), lower(VectorX::Constant(n, -no_bound)), upper(VectorX::Constant(n, no_bound)) {}

void LinearProgram::add_row(double low, const VectorX& row, double high) {
  if (used_ == rows.rows()) {
    const Eigen::Index room = std::max<Eigen::Index>(16, 2 * used_);
    rows.conservativeResize(room, cost.size());
    row_lower.conservativeResize(room);
    row_upper.conservativeResize(room);
  }
  rows.row(used_) = row.transpose();
  row_lower[used_] = low;
  row_upper[used_] = high;
  ++used_;
}

namespace {

/// Clp takes larger numbers for infinite, and ends the program where it meets one.
constexpr double clp_infinity = 1e25;

/// false for NaN, too
bool is_clp_finite(const Eigen::Ref<const MatrixX>& numbers) { return (numbers.array().abs() < clp_infinity).all(); }

/// Clp stops at these violations of limits and optimality; its own default, 1e-7, is too coarse for a proof.
constexpr double clp_tolerance = 1e-10;

std::vector<double> limits(const VectorX& values, Eigen::Index count) {
  std::vector<double> out(values.data(), values.data() + count);
  for (double& v : out) v = std::clamp(v, -COIN_DBL_MAX, COIN_DBL_MAX);
  return out;
}

CoinPackedMatrix pack_rows(const LinearProgram& program) {
  std::vector<int> at_row, at_column;
  std::vector<double> entries;
  for (Eigen::Index r = 0; r < program.row_count(); ++r)
    for (Eigen::Index c = 0; c < program.cost.size(); ++c) {
      if (program.rows(r, c) == 0) continue;
      at_row.push_back(static_cast<int>(r));
      at_column.push_back(static_cast<int>(c));
      entries.push_back(program.rows(r, c));
    }
  CoinPackedMatrix matrix(true, at_row.data(), at_column.data(), entries.data(),
                          static_cast<CoinBigIndex>(entries.size()));
  matrix.setDimensions(static_cast<int>(program.row_count()), static_cast<int>(program.cost.size()));
  return matrix;
}

}  // namespace

LinearProgramSolution solve_linear_program(const LinearProgram& program) {
  const Eigen::Index n = program.cost.size(), m = program.row_count();
  if (!is_clp_finite(program.cost) || !is_clp_finite(program.rows.topRows(m))) return {};
  const auto lower = limits(program.lower, n), upper = limits(program.upper, n);
  const auto row_lower = limits(program.row_lower, m), row_upper = limits(program.row_upper, m);
  ClpSimplex model;
  model.setLogLevel(0);
  model.loadProblem(pack_rows(program), lower.data(), upper.data(), program.cost.data(), row_lower.data(),
                    row_upper.data());
  model.setPrimalTolerance(clp_tolerance);
  model.setDualTolerance(clp_tolerance);
  model.setMaximumIterations(50000);
  model.primal();
  LinearProgramSolution solution;
  switch (model.status()) {
    case 0: solution.status = LinearProgramStatus::optimal; break;
    case 1: solution.status = LinearProgramStatus::infeasible; break;
    case 2: solution.status = LinearProgramStatus::unbounded; break;
    default: break;
  }
  if (solution.status == LinearProgramStatus::optimal)
    solution.x = Eigen::Map<const VectorX>(model.primalColumnSolution(), n);
  return solution;
}

}  // namespace balance
