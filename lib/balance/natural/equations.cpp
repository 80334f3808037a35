#include "balance/natural/equations.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace balance::natural {

namespace {

constexpr double solved = 1e-12;  // residual after which one correction is the last
constexpr int newton_steps = 10;

/// Farthest fixed point in characteristic lengths: what round-off is proportional to.
double extent(const Model& model) {
  double largest = 1;
  for (const Complex p : model.basic.fixed) largest = std::max(largest, std::abs(p));
  return largest;
}

}  // namespace

Equations::Equations(const Model& model, DriveRows drive)
    : model_(model), drive_(std::move(drive)), round_off_(solved * extent(model)) {
  square_ = rows() == unknowns();
}

VectorX Equations::residual(const Coordinates& position, const VectorX& prescribed) const {
  VectorX out(rows());
  for (int r = 0; r < constraints(); ++r) out[r] = model_.constraints[static_cast<std::size_t>(r)].value(position);
  for (int k = 0; k < driven(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out[constraints() + k] = drive_.rows[i].value(position) - prescribed[k] / drive_.unit[i];
  }
  return out;
}

MatrixX Equations::jacobian(const Coordinates& position) const {
  MatrixX out(rows(), unknowns());
  Eigen::RowVectorXd row(unknowns());
  for (int r = 0; r < rows(); ++r) {
    const Row& equation = r < constraints() ? model_.constraints[static_cast<std::size_t>(r)]
                                            : drive_.rows[static_cast<std::size_t>(r - constraints())];
    equation.gradient(position, model_.basic.moving, row);
    out.row(r) = row;
  }
  return out;
}

MatrixX Equations::constraint_jacobian(const Coordinates& position) const {
  return jacobian(position).topRows(constraints());
}

VectorX Equations::measure(const Coordinates& position) const {
  VectorX out(driven());
  for (int k = 0; k < driven(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out[k] = drive_.unit[i] * drive_.rows[i].value(position);
  }
  return out;
}

bool Equations::factorise(const Coordinates& position) {
  const MatrixX matrix = jacobian(position);
  if (!square_) {
    qr_.compute(matrix);
    return qr_.rank() == unknowns();
  }
  lu_.compute(matrix);
  const auto diagonal = lu_.matrixLU().diagonal();
  return std::all_of(diagonal.begin(), diagonal.end(), [](double pivot) { return std::abs(pivot) > 1e-300; });
}

VectorX Equations::solve(const VectorX& right) const {
  if (square_) return lu_.solve(right);
  return qr_.solve(right);
}

bool Equations::newton(Coordinates& position, const VectorX& prescribed) {
  double last = INFINITY;
  for (iterations_ = 0; iterations_ <= newton_steps; ++iterations_) {
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

bool Equations::approach(Coordinates& position, const VectorX& prescribed) const {
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

bool Equations::differentiate(State& state, const DriveSample& sample) {
  if (!factorise(state.position)) return false;
  VectorX right = VectorX::Zero(rows());
  for (int k = 0; k < driven(); ++k)
    right[constraints() + k] = sample.rate[k] / drive_.unit[static_cast<std::size_t>(k)];
  state.velocity.set(solve(right));
  accelerate(state, sample);
  return true;
}

void Equations::accelerate(State& state, const DriveSample& sample) const {
  VectorX right(rows());
  for (int r = 0; r < constraints(); ++r)
    right[r] = -model_.constraints[static_cast<std::size_t>(r)].bias(state.position, state.velocity);
  for (int k = 0; k < driven(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    right[constraints() + k] =
        sample.acceleration[k] / drive_.unit[i] - drive_.rows[i].bias(state.position, state.velocity);
  }
  state.acceleration.set(solve(right));
}

MatrixX Equations::motions() const {
  MatrixX right = MatrixX::Zero(rows(), driven());
  right.bottomRows(driven()).setIdentity();
  MatrixX out(unknowns(), driven());
  for (int k = 0; k < driven(); ++k) out.col(k) = solve(right.col(k));
  return out;
}

namespace {

int numerical_rank(const MatrixX& matrix) {
  if (matrix.size() == 0) return 0;
  const VectorX values = singular_values(matrix);
  int rank = 0;
  while (rank < values.size() && values[rank] > 1e-8 * values[0]) ++rank;
  return rank;
}

}  // namespace

int generic_rank(const Model& model, const Coordinates& position) {
  Equations constraints(model, {});
  Coordinates here = position;
  int best = numerical_rank(constraints.jacobian(here));
  std::mt19937 random(1);
  for (int k = 0; k < 4 && best < model.unknowns() && constraints.rows() > 0; ++k) {
    VectorX step(model.unknowns());
    for (double& entry : step) entry = (static_cast<double>(random()) / 4294967296.0 - 0.5) * 0.2;
    Coordinates there = here;
    const CompleteOrthogonalDecomposition qr(constraints.jacobian(here));
    there.add(1, step - qr.solve(constraints.jacobian(here) * step));
    if (!constraints.approach(there, VectorX())) continue;
    here = there;
    best = std::max(best, numerical_rank(constraints.jacobian(here)));
  }
  return best;
}

}  // namespace balance::natural
