#include "balance/foundation/numerics/levenberg_marquardt.hpp"

#include "balance/foundation/numerics/bounded_least_squares.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::numerics {

namespace {

/// No further improvement is possible below this residual.
constexpr double max_residual_tolerance = 1e-16;
/// A step that fails with residuals this small fails because of round-off.
constexpr double rounding_residual_tolerance = 1e-12;
/// Relative decrease of the sum of squares that counts as a stall, and the maximum number of stalls in a row.
constexpr double stall_tolerance = 1e-10;
constexpr int max_stalled_iterations = 4;
/// Steps before `stop` is polled: most descents need no more.
constexpr int min_iterations = 20;

/// The damped step within the bounds: min |r + J d|² + damping |d|².
VectorX solve_damped_step(const MatrixX& jacobian, const VectorX& values, const VectorX& u, double damping) {
  const auto m = jacobian.rows(), n = jacobian.cols();
  MatrixX a(m + n, n);
  a << jacobian, std::sqrt(damping) * MatrixX::Identity(n, n);
  VectorX b = VectorX::Zero(m + n), d = VectorX::Zero(n);
  b.head(m) = -values;
  bounded_least_squares(a, b, (-1.0 - u.array()).matrix(), (1.0 - u.array()).matrix(), d);
  return d;
}

/// u + d, with bounds hit exactly.
VectorX apply_step(const VectorX& u, const VectorX& d) {
  VectorX next = u + d;
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    if (d[i] <= -1 - u[i]) next[i] = -1;
    if (d[i] >= 1 - u[i]) next[i] = 1;
  }
  return next;
}

}  // namespace

NonlinearSystem restrict_to_variables(const NonlinearSystem& equations, const std::vector<int>& variables,
                                      const VectorX& u) {
  NonlinearSystem restricted{equations.primary_rows, equations.row_count, {}};
  restricted.evaluate = [&equations, variables, all = u](const VectorX& v, VectorX& values, MatrixX* jacobian) mutable {
    all(variables) = v;
    MatrixX slopes;
    if (!equations.evaluate(all, values, jacobian != nullptr ? &slopes : nullptr)) return false;
    if (jacobian != nullptr) *jacobian = slopes(Eigen::all, variables);
    return true;
  };
  return restricted;
}

LeastSquaresResult solve_levenberg_marquardt(const NonlinearSystem& equations, VectorX start, int iterations,
                                             const std::function<bool()>& stop) {
  LeastSquaresResult result{std::move(start), {}, std::numeric_limits<double>::infinity()};
  MatrixX jacobian;
  if (!equations.evaluate(result.u, result.values, &jacobian)) return result;
  if (result.values.size() == 0 || result.u.size() == 0) {
    result.max_residual = max_abs(result.values);
    return result;
  }
  const double jacobian_scale = std::max(max_abs(jacobian.colwise().squaredNorm()), 1e-30);
  double damping = 1e-10 * jacobian_scale;
  int stalls = 0;
  VectorX values;
  for (int iteration = 0; iteration < iterations && max_abs(result.values) > max_residual_tolerance; ++iteration) {
    if (iteration >= min_iterations && stop && stop()) break;
    const VectorX d = solve_damped_step(jacobian, result.values, result.u, damping);
    const double cost = result.values.squaredNorm();
    const double predicted = cost - (result.values + jacobian * d).squaredNorm();
    if (!(predicted > 1e-15 * cost) || d.norm() < 1e-16) break;
    const VectorX next = apply_step(result.u, d);
    const bool valid = equations.evaluate(next, values, nullptr);
    const double gain_ratio = valid ? (cost - values.squaredNorm()) / predicted : -1;
    if (!(gain_ratio > 1e-4)) {
      if (max_abs(result.values) < rounding_residual_tolerance || damping > 1e8 * jacobian_scale) break;
      damping = std::max(10 * damping, 1e-6 * jacobian_scale);
      continue;
    }
    stalls = values.squaredNorm() > (1 - stall_tolerance) * cost ? stalls + 1 : 0;
    result.u = next;
    if (!equations.evaluate(next, result.values, &jacobian) || stalls >= max_stalled_iterations) break;
    if (gain_ratio > 0.5) damping = std::max(damping / 10, 1e-14 * jacobian_scale);
  }
  result.max_residual = max_abs(result.values);
  return result;
}

}  // namespace balance::numerics
