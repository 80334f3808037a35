#include "balance/kinematics/assembly.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/base/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace balance {

template <class S>
VectorX column_scale(const Tree<S>& tree) {
  VectorX scale = VectorX::Ones(tree.columns);
  for (int c = 0; c < tree.columns; ++c)
    if (tree.is_length_column[c]) scale[c] = tree.characteristic_length;
  return scale;
}

namespace {

/// The least-norm solution of J x = r, as far as there is one.
VectorX solve_least_norm_step(const MatrixX& jacobian, const VectorX& residual) {
  CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-9);
  qr.compute(jacobian);
  return qr.solve(residual);
}

/// What the damping leaves is made up for by the second step and, in an iteration, by the next ones.
VectorX solve_least_norm_step(const SparseMatrix& jacobian, const VectorX& residual) {
  const double shift = 1e-12 * jacobian.squaredNorm() / static_cast<double>(jacobian.cols());
  const VectorX first = solve_damped_least_squares(jacobian, residual, shift);
  return first + solve_damped_least_squares(jacobian, residual - jacobian * first, shift);
}

/// Quadratic end game: least-norm Newton steps as long as they help.
template <class Matrix, class S>
void polish_by_newton(ConstraintSystem<S>& system, const VectorX& scale, const DriveSample& target,
                      AssemblySolution& solution) {
  VectorX residual, trial;
  Matrix jacobian;
  system.evaluate(solution.y, target, residual, jacobian);
  for (int k = 0; k < 8 && residual.size() > 0; ++k) {
    const double before = residual.template lpNorm<Eigen::Infinity>();
    solution.residual = before;
    if (before < 1e-15) break;
    trial = solution.y - scale.cwiseProduct(solve_least_norm_step(jacobian, residual));
    system.evaluate(trial, target, residual, jacobian);
    if (!(residual.template lpNorm<Eigen::Infinity>() < before)) break;
    solution.y = trial;
    solution.residual = residual.template lpNorm<Eigen::Infinity>();
  }
  system.evaluate(solution.y, target, residual, jacobian);
}

/// Levenberg and Marquardt's steps, of any damping, from one configuration.
class DampedNormalEquations {
 public:
  DampedNormalEquations(const MatrixX& jacobian, const VectorX& residual)
      : normal_(jacobian.transpose() * jacobian),
        gradient_(jacobian.transpose() * residual),
        largest_(max_coefficient(normal_.diagonal())) {}
  VectorX step(double damping) const {
    MatrixX damped = normal_;
    damped.diagonal().array() += damping * std::max(1e-6, largest_);
    return damped.ldlt().solve(gradient_);
  }

 private:
  MatrixX normal_;
  VectorX gradient_;
  double largest_;
};

class SparseDampedNormalEquations {
 public:
  SparseDampedNormalEquations(const SparseMatrix& jacobian, const VectorX& residual)
      : jacobian_(jacobian), residual_(residual) {
    for (Eigen::Index c = 0; c < jacobian.cols(); ++c) largest_ = std::max(largest_, jacobian.col(c).squaredNorm());
  }
  VectorX step(double damping) const {
    return solve_damped_least_squares(jacobian_, residual_, damping * std::max(1e-6, largest_));
  }

 private:
  const SparseMatrix& jacobian_;
  const VectorX& residual_;
  double largest_ = 0;
};

template <class Matrix, class StepsOf, class S>
AssemblySolution search_levenberg_marquardt(ConstraintSystem<S>& system, const VectorX& guess,
                                            const DriveSample& target, int iterations) {
  AssemblySolution solution;
  solution.y = guess;
  const VectorX scale = column_scale(system.tree());
  VectorX residual, trial_residual;
  Matrix jacobian, trial_jacobian;
  system.evaluate(solution.y, target, residual, jacobian);
  double cost = residual.squaredNorm(), damping = 1e-3;
  for (; solution.iterations < iterations && cost > 1e-18; ++solution.iterations) {
    const StepsOf steps(jacobian, residual);
    bool better = false;
    for (int tries = 0; tries < 12 && !better; ++tries) {
      VectorX step = steps.step(damping);
      const double longest = step.template lpNorm<Eigen::Infinity>();
      if (longest > 1) step /= longest;  // no more than one radian or one length at a time
      const VectorX trial = solution.y - scale.cwiseProduct(step);
      system.evaluate(trial, target, trial_residual, trial_jacobian);
      const double trial_cost = trial_residual.squaredNorm();
      better = trial_cost < cost;
      if (better) {
        const bool stalled = cost - trial_cost < 1e-10 * cost;
        solution.y = trial, cost = trial_cost;
        residual.swap(trial_residual), jacobian.swap(trial_jacobian);
        damping = std::max(1e-12, damping / 5);
        if (stalled) better = false, tries = 12;
      } else {
        damping *= 4;
      }
    }
    if (!better) break;
  }
  solution.residual = residual.size() > 0 ? residual.template lpNorm<Eigen::Infinity>() : 0;
  if (solution.residual < 1e-4) polish_by_newton<Matrix>(system, scale, target, solution);
  solution.found = solution.residual < closure_tolerance && system.is_aligned();
  return solution;
}

}  // namespace

template <class S>
AssemblySolution solve_assembly(ConstraintSystem<S>& system, const VectorX& guess, const DriveSample& target,
                                int iterations) {
  return system.columns() > max_dense_columns
             ? search_levenberg_marquardt<SparseMatrix, SparseDampedNormalEquations>(system, guess, target, iterations)
             : search_levenberg_marquardt<MatrixX, DampedNormalEquations>(system, guess, target, iterations);
}

template <class S>
VectorX random_coordinates(const Tree<S>& tree, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  VectorX y(tree.columns);
  for (int c = 0; c < tree.columns; ++c) {
    // written out: the standard's distributions differ between libraries
    const double unit = 2 * (static_cast<double>(random() >> 11) * 0x1.0p-53) - 1;
    y[c] = unit * (tree.is_length_column[c] ? tree.characteristic_length : std::numbers::pi);
  }
  return y;
}

RankDecomposition decompose_rank(const MatrixX& jacobian, double tolerance) {
  RankDecomposition report;
  const Eigen::Index columns = jacobian.cols();
  if (jacobian.rows() == 0 || columns == 0) {
    report.null_space = MatrixX::Identity(columns, columns);
    return report;
  }
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  const VectorX& values = svd.singularValues();
  const double largest = values[0];
  while (report.rank < values.size() && values[report.rank] > tolerance * largest && largest > 0) ++report.rank;
  report.null_space = svd.matrixV().rightCols(columns - report.rank);
  return report;
}

namespace {

/// There is no larger rank: no singular value is anywhere near the limit of rank_of().
template <class S>
bool has_proven_full_rank(ConstraintSystem<S>& closures, const VectorX& y) {
  VectorX residual;
  SparseMatrix jacobian;
  closures.evaluate(y, {}, residual, jacobian);
  return min_singular_value(jacobian).has_value();
}

/// @param rates the rows of closures of rates count, too
template <class S>
int find_generic_rank(const Tree<S>& tree, const VectorX& y, bool rates) {
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const int rows = rates ? closures.closure_rows() : closures.place_rows(), full = std::min(rows, closures.columns());
  if (full == 0 || (full > max_dense_columns && rows == closures.place_rows() && has_proven_full_rank(closures, y)))
    return full;
  const VectorX scale = column_scale(tree);
  VectorX here = y;
  MatrixX jacobian;
  closures.velocity_jacobian(here, {}, jacobian);
  RankDecomposition last = decompose_rank(jacobian.topRows(rows));
  int best = last.rank;
  for (std::uint64_t seed = 1; seed <= 4 && best < full && last.null_space.cols() > 0; ++seed) {
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    VectorX direction = last.null_space * (last.null_space.transpose() * random);
    if (direction.norm() < 1e-12) break;
    direction *= 0.15 / direction.norm();
    const AssemblySolution moved = solve_assembly(closures, here + scale.cwiseProduct(direction), {});
    if (!moved.found || (moved.y - here).cwiseQuotient(scale).norm() < 1e-6) continue;
    here = moved.y;
    closures.velocity_jacobian(here, {}, jacobian);
    last = decompose_rank(jacobian.topRows(rows));
    best = std::max(best, last.rank);
  }
  return best;
}

}  // namespace

template <class S>
int find_generic_closure_rank(const Tree<S>& tree, const VectorX& y) {
  return find_generic_rank(tree, y, true);
}

template <class S>
int find_generic_position_rank(const Tree<S>& tree, const VectorX& y) {
  return find_generic_rank(tree, y, false);
}

template <class S>
AssemblySolution track_to(ConstraintSystem<S>& system, const VectorX& y, const DriveSample& from,
                          const DriveSample& to) {
  AssemblySolution here{true, y, 0, 0};
  const Vector3 turn = rotation_vector_of(to.rotation * from.rotation.transpose());
  const VectorX scale = column_scale(system.tree());
  double done = 0, step = 1.0 / 32;
  VectorX slope = VectorX::Zero(y.size());
  while (done < 1) {
    const double next = std::min(1.0, done + step);
    DriveSample target;
    target.value = (1 - next) * from.value + next * to.value;
    target.rotation = next == 1 ? to.rotation : Matrix3(rotation_from_rotation_vector(next * turn) * from.rotation);
    const AssemblySolution trial = solve_assembly(system, here.y + (next - done) * slope, target, 30);
    const double change = (trial.y - here.y).cwiseQuotient(scale).template lpNorm<Eigen::Infinity>();
    if (trial.found && change < 0.5) {
      slope = (trial.y - here.y) / (next - done);
      here = trial;
      done = next;
      step = std::min(2 * step, 1.0 / 16);
    } else {
      step /= 2;
      slope.setZero();
      if (step < 1e-6) return {false, here.y, trial.residual, 0};
    }
  }
  return here;
}

#define BALANCE_INSTANTIATE(S)                                                                                \
  template VectorX column_scale<S>(const Tree<S>&);                                                           \
  template AssemblySolution solve_assembly<S>(ConstraintSystem<S>&, const VectorX&, const DriveSample&, int); \
  template VectorX random_coordinates<S>(const Tree<S>&, std::uint64_t);                                      \
  template int find_generic_closure_rank<S>(const Tree<S>&, const VectorX&);                                  \
  template int find_generic_position_rank<S>(const Tree<S>&, const VectorX&);                                 \
  template AssemblySolution track_to<S>(ConstraintSystem<S>&, const VectorX&, const DriveSample&, const DriveSample&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
