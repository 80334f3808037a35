#include "balance/natural/equations.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace balance::natural {

namespace {

constexpr double natural_residual_tolerance = 1e-12;  // residual after which one correction is the last
constexpr int max_newton_iterations = 10;

/// Farthest fixed point in characteristic lengths: what round-off is proportional to.
double compute_ground_extent(const NaturalModel& model) {
  double largest = 1;
  for (const Complex p : model.basic.fixed) largest = std::max(largest, std::abs(p));
  return largest;
}

}  // namespace

NaturalKinematicEquations::NaturalKinematicEquations(const NaturalModel& model, DriveRows drive)
    : model_(model), drive_(std::move(drive)), round_off_(natural_residual_tolerance * compute_ground_extent(model)) {
  square_ = rows() == unknown_count();
}

VectorX NaturalKinematicEquations::residual(const NaturalCoordinates& position, const VectorX& prescribed) const {
  VectorX out(rows());
  for (int r = 0; r < constraint_count(); ++r) out[r] = model_.constraints[static_cast<std::size_t>(r)].value(position);
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out[constraint_count() + k] = drive_.rows[i].value(position) - prescribed[k] / drive_.unit[i];
  }
  return out;
}

MatrixX NaturalKinematicEquations::jacobian(const NaturalCoordinates& position) const {
  MatrixX out(rows(), unknown_count());
  Eigen::RowVectorXd row(unknown_count());
  for (int r = 0; r < rows(); ++r) {
    const ConstraintRow& equation = r < constraint_count()
                                        ? model_.constraints[static_cast<std::size_t>(r)]
                                        : drive_.rows[static_cast<std::size_t>(r - constraint_count())];
    equation.gradient(position, model_.basic.moving, row);
    out.row(r) = row;
  }
  return out;
}

MatrixX NaturalKinematicEquations::constraint_jacobian(const NaturalCoordinates& position) const {
  return jacobian(position).topRows(constraint_count());
}

VectorX NaturalKinematicEquations::measure(const NaturalCoordinates& position) const {
  VectorX out(drive_row_count());
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out[k] = drive_.unit[i] * drive_.rows[i].value(position);
  }
  return out;
}

bool NaturalKinematicEquations::factorise(const NaturalCoordinates& position) {
  const MatrixX matrix = jacobian(position);
  if (!square_) {
    qr_.compute(matrix);
    return qr_.rank() == unknown_count();
  }
  lu_.compute(matrix);
  const auto diagonal = lu_.matrixLU().diagonal();
  return std::all_of(diagonal.begin(), diagonal.end(), [](double pivot) { return std::abs(pivot) > 1e-300; });
}

VectorX NaturalKinematicEquations::solve(const VectorX& right) const {
  if (square_) return lu_.solve(right);
  return qr_.solve(right);
}

bool NaturalKinematicEquations::newton(NaturalCoordinates& position, const VectorX& prescribed) {
  double last = INFINITY;
  for (iterations_ = 0; iterations_ <= max_newton_iterations; ++iterations_) {
    const VectorX off = residual(position, prescribed);
    const double worst = off.size() > 0 ? off.lpNorm<Eigen::Infinity>() : 0;
    if (!std::isfinite(worst) || !factorise(position)) return false;
    position.add(-1, solve(off));
    // either small, or as small as round-off allows
    if (worst <= round_off_ || (worst <= 10 * round_off_ && worst >= last)) return true;
    last = worst;
  }
  return false;
}

bool NaturalKinematicEquations::solve_least_norm(NaturalCoordinates& position, const VectorX& prescribed) const {
  for (int k = 0; k < 30; ++k) {
    const VectorX off = residual(position, prescribed);
    const double worst = off.size() > 0 ? off.lpNorm<Eigen::Infinity>() : 0;
    if (!std::isfinite(worst)) return false;
    CompleteOrthogonalDecomposition qr;
    qr.setThreshold(1e-9);
    qr.compute(jacobian(position));
    const VectorX step = qr.solve(off);
    if (!step.allFinite()) return false;
    const double longest = step.size() > 0 ? step.lpNorm<Eigen::Infinity>() : 0;
    position.add(longest > 1 ? -1 / longest : -1, step);
    if (worst <= 10 * round_off_) return true;
  }
  return false;
}

bool NaturalKinematicEquations::differentiate(NaturalState& state, const DriveSample& sample) {
  if (!factorise(state.position)) return false;
  VectorX right = VectorX::Zero(rows());
  for (int k = 0; k < drive_row_count(); ++k)
    right[constraint_count() + k] = sample.rate[k] / drive_.unit[static_cast<std::size_t>(k)];
  state.velocity.set(solve(right));
  accelerate(state, sample);
  return true;
}

void NaturalKinematicEquations::accelerate(NaturalState& state, const DriveSample& sample) const {
  VectorX right(rows());
  for (int r = 0; r < constraint_count(); ++r)
    right[r] = -model_.constraints[static_cast<std::size_t>(r)].bias(state.position, state.velocity);
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    right[constraint_count() + k] =
        sample.acceleration[k] / drive_.unit[i] - drive_.rows[i].bias(state.position, state.velocity);
  }
  state.acceleration.set(solve(right));
}

MatrixX NaturalKinematicEquations::allowed_velocities() const {
  MatrixX right = MatrixX::Zero(rows(), drive_row_count());
  right.bottomRows(drive_row_count()).setIdentity();
  MatrixX out(unknown_count(), drive_row_count());
  for (int k = 0; k < drive_row_count(); ++k) out.col(k) = solve(right.col(k));
  return out;
}

namespace {

int compute_numerical_rank(const MatrixX& matrix) {
  if (matrix.size() == 0) return 0;
  const VectorX values = singular_values(matrix);
  int rank = 0;
  while (rank < values.size() && values[rank] > 1e-8 * values[0]) ++rank;
  return rank;
}

}  // namespace

int find_generic_constraint_rank(const NaturalModel& model, const NaturalCoordinates& position) {
  NaturalKinematicEquations constraints(model, {});
  NaturalCoordinates here = position;
  int best = compute_numerical_rank(constraints.jacobian(here));
  std::mt19937 random(1);
  for (int k = 0; k < 4 && best < model.unknowns() && constraints.rows() > 0; ++k) {
    VectorX step(model.unknowns());
    for (double& entry : step) entry = (static_cast<double>(random()) / 4294967296.0 - 0.5) * 0.2;
    NaturalCoordinates there = here;
    const CompleteOrthogonalDecomposition qr(constraints.jacobian(here));
    there.add(1, step - qr.solve(constraints.jacobian(here) * step));
    if (!constraints.solve_least_norm(there, VectorX())) continue;
    here = there;
    best = std::max(best, compute_numerical_rank(constraints.jacobian(here)));
  }
  return best;
}

}  // namespace balance::natural
