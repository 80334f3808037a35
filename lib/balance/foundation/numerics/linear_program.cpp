#include "balance/foundation/numerics/linear_program.hpp"

#include "balance/foundation/numerics/inequality_program.hpp"

#include <ClpSimplex.hpp>

#include <algorithm>
#include <vector>

namespace balance::numerics {

LinearProgram::LinearProgram(Eigen::Index n)
    : cost(VectorX::Zero(n)), lower(VectorX::Constant(n, -no_bound)), upper(VectorX::Constant(n, no_bound)) {}

void LinearProgram::add_row(double low, const VectorX& row, double high) {
  if (row_count_ == rows.rows()) {
    const Eigen::Index capacity = std::max<Eigen::Index>(16, 2 * row_count_);
    rows.conservativeResize(capacity, cost.size());
    row_lower.conservativeResize(capacity);
    row_upper.conservativeResize(capacity);
  }
  rows.row(row_count_) = row.transpose();
  row_lower[row_count_] = low;
  row_upper[row_count_] = high;
  ++row_count_;
}

namespace {

/// Clp treats larger numbers as infinite and terminates the process if it meets one.
constexpr double clp_infinity = 1e25;

/// Also false for NaN.
bool is_clp_finite(const Eigen::Ref<const MatrixX>& numbers) { return (numbers.array().abs() < clp_infinity).all(); }

/// Clp's tolerance of feasibility and optimality; its own default, 1e-7, is too coarse for a proof.
constexpr double clp_tolerance = 1e-10;

std::vector<double> clamp_bounds(const VectorX& values, Eigen::Index count) {
  std::vector<double> out(values.data(), values.data() + count);
  for (double& v : out) v = std::clamp(v, -COIN_DBL_MAX, COIN_DBL_MAX);
  return out;
}

CoinPackedMatrix pack_rows(const LinearProgram& program) {
  std::vector<int> row_indices, column_indices;
  std::vector<double> entries;
  for (Eigen::Index r = 0; r < program.row_count(); ++r)
    for (Eigen::Index c = 0; c < program.cost.size(); ++c) {
      if (program.rows(r, c) == 0) continue;
      row_indices.push_back(static_cast<int>(r));
      column_indices.push_back(static_cast<int>(c));
      entries.push_back(program.rows(r, c));
    }
  CoinPackedMatrix matrix(true, row_indices.data(), column_indices.data(), entries.data(),
                          static_cast<CoinBigIndex>(entries.size()));
  matrix.setDimensions(static_cast<int>(program.row_count()), static_cast<int>(program.cost.size()));
  return matrix;
}

}  // namespace

LinearProgramSolution solve_linear_program(const LinearProgram& program) {
  const Eigen::Index n = program.cost.size(), m = program.row_count();
  if (!is_clp_finite(program.cost) || !is_clp_finite(program.rows.topRows(m))) return {};
  const auto lower = clamp_bounds(program.lower, n), upper = clamp_bounds(program.upper, n);
  const auto row_lower = clamp_bounds(program.row_lower, m), row_upper = clamp_bounds(program.row_upper, m);
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

InequalityProgramSolution solve_inequality_program(const VectorX& gain, const MatrixX& rows, const VectorX& limits) {
  if (!is_clp_finite(gain) || !is_clp_finite(rows) || !is_clp_finite(limits)) return {};
  const auto n = static_cast<int>(rows.cols()), m = static_cast<int>(rows.rows());
  std::vector<CoinBigIndex> starts{0};  // of the dual's columns
  std::vector<int> indices;
  std::vector<double> entries;
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < n; ++c) {
      if (rows(r, c) == 0) continue;
      indices.push_back(c);
      entries.push_back(rows(r, c));
    }
    starts.push_back(static_cast<CoinBigIndex>(entries.size()));
  }
  ClpSimplex model;
  model.setLogLevel(0);
  const std::vector<double> lower(static_cast<std::size_t>(m), 0.0), upper(static_cast<std::size_t>(m), COIN_DBL_MAX);
  model.loadProblem(m, n, starts.data(), indices.data(), entries.data(), lower.data(), upper.data(), limits.data(),
                    gain.data(), gain.data());
  model.setPrimalTolerance(clp_tolerance);
  model.setDualTolerance(clp_tolerance);
  model.setMaximumIterations(50000);
  model.dual();
  InequalityProgramSolution solution;
  switch (model.status()) {
    case 0: solution.status = LinearProgramStatus::optimal; break;
    case 1: solution.status = LinearProgramStatus::unbounded; break;
    case 2: solution.status = LinearProgramStatus::infeasible; break;
    default: break;
  }
  if (solution.status != LinearProgramStatus::optimal) return solution;
  solution.x = Eigen::Map<const VectorX>(model.dualRowSolution(), n);
  solution.multipliers = Eigen::Map<const VectorX>(model.primalColumnSolution(), m);
  return solution;
}

}  // namespace balance::numerics
