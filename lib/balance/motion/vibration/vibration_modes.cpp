#include "balance/motion/vibration/vibration_modes.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace balance::vibration {

namespace {

/// Eigenvalues, or real parts, below these fractions of the largest eigenvalue are round-off.
constexpr double eigenvalue_round_off = 1e-9, damping_round_off = 1e-9;
constexpr double stiffness_round_off = 1e-11;  ///< singular values below this fraction of the largest one are round-off
constexpr double equal_eigenvalues = 1e-8;     ///< relative difference: which of the modes comes first is arbitrary

/// ẋ = A x in units, with time in units of 1 / rate. Deviations that exert and change nothing, the null space of the
/// stiffness, are rigid motions with λ = 0; the state x = (y, δ̇) has only the others, (δ, ε) = V y + rigid motions, so that
/// a rigid motion does not make a double eigenvalue, which would be known to half of the digits.
struct StateEquation {
  MatrixX matrix;
  MatrixX deviations;  ///< V: coordinates × y
  MatrixX rigid;       ///< coordinates × rigid motions
  MatrixX rates;       ///< of the coordinates from the state
  double rate = 1;
};

StateEquation make_state_equation(const LinearMotion& motion) {
  const LinearCoefficients& at = motion.coefficients;
  const Eigen::Index n = motion.free_count, size = motion.unit.size(), m = size - n;
  const VectorX &unit = motion.unit, free_unit = unit.head(n), following_unit = unit.tail(m);
  const Eigen::PartialPivLU<MatrixX> mass(at.mass);
  MatrixX stiffness = free_unit.cwiseInverse().asDiagonal() * mass.solve(at.stiffness) * unit.asDiagonal(),
          damping = free_unit.cwiseInverse().asDiagonal() * mass.solve(at.damping) * free_unit.asDiagonal(),
          following = following_unit.cwiseInverse().asDiagonal() * at.following_stiffness * unit.asDiagonal();
  StateEquation state;
  const double rate = std::max({std::sqrt(stiffness.norm()), damping.norm(), following.norm()});
  state.rate = rate > 0 ? rate : 1;
  stiffness /= state.rate * state.rate, damping /= state.rate, following /= state.rate;
  MatrixX effects(size, size);
  effects << stiffness, following;
  const numerics::SingularValueDecomposition decomposition(effects, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < size && decomposition.singularValues()[rank] > stiffness_round_off) ++rank;
  state.deviations = decomposition.matrixV().leftCols(rank);
  state.rigid = decomposition.matrixV().rightCols(size - rank);
  MatrixX rates = MatrixX::Zero(size, rank + n);
  rates.topRightCorner(n, n).setIdentity();
  rates.bottomLeftCorner(m, rank) = following * state.deviations;
  rates.bottomRightCorner(m, n) =
      following_unit.cwiseInverse().asDiagonal() * at.following_damping * free_unit.asDiagonal();
  state.matrix.resize(rank + n, rank + n);
  state.matrix.topRows(rank) = state.deviations.transpose() * rates;
  state.matrix.bottomLeftCorner(n, rank) = -stiffness * state.deviations;
  state.matrix.bottomRightCorner(n, n) = -damping;
  state.rates = std::move(rates);
  return state;
}

/// The largest entry, in units, becomes 1.
VibrationMode make_mode(const LinearMotion& motion, std::complex<double> eigenvalue, Eigen::VectorXcd shape) {
  std::complex<double> largest = 0;
  for (const std::complex<double> entry : shape)
    if (std::abs(entry) > (1 + equal_eigenvalues) * std::abs(largest)) largest = entry;
  if (largest != 0.0) shape /= largest;
  return {eigenvalue, shape.cwiseProduct(motion.unit)};
}

Eigen::Index largest_entry(const VibrationMode& mode, const VectorX& unit) {
  return numerics::max_index(mode.shape.cwiseAbs().cwiseQuotient(unit));
}

/// By size of the eigenvalue; equal ones by their largest coordinate.
void sort_modes(std::vector<VibrationMode>& modes, const VectorX& unit) {
  std::stable_sort(modes.begin(), modes.end(), [](const VibrationMode& a, const VibrationMode& b) {
    return std::abs(a.eigenvalue) < std::abs(b.eigenvalue);
  });
  for (auto begin = modes.begin(); begin != modes.end();) {
    const double limit = std::abs(begin->eigenvalue) * (1 + equal_eigenvalues);
    const auto end =
        std::find_if(begin, modes.end(), [&](const VibrationMode& mode) { return std::abs(mode.eigenvalue) > limit; });
    std::stable_sort(begin, end, [&](const VibrationMode& a, const VibrationMode& b) {
      return largest_entry(a, unit) < largest_entry(b, unit);
    });
    begin = end;
  }
}

void solve_modes(VibrationModes& result) {
  const LinearMotion& motion = result.motion;
  const StateEquation state = make_state_equation(motion);
  for (Eigen::Index k = 0; k < state.rigid.cols(); ++k) {
    result.eigenvalues.emplace_back(0);
    result.modes.push_back(make_mode(motion, 0, state.rigid.col(k).cast<std::complex<double>>()));
  }
  if (state.matrix.rows() > 0) {
    const Eigen::EigenSolver<MatrixX> solver(state.matrix);
    for (Eigen::Index k = 0; k < state.matrix.rows(); ++k) {
      std::complex<double> value = solver.eigenvalues()[k];
      result.eigenvalues.push_back(state.rate * value);
      if (std::abs(value) <= eigenvalue_round_off) value = 0;
      if (std::abs(value.real()) <= damping_round_off) value.real(0);
      if (value.imag() < 0) continue;  // the conjugate of another
      // δ = δ̇ / λ; a rigid motion at constant rates has the shape of its rates
      result.modes.push_back(make_mode(motion, state.rate * value, state.rates * solver.eigenvectors().col(k)));
    }
  }
  sort_modes(result.modes, motion.unit);
  std::sort(result.eigenvalues.begin(), result.eigenvalues.end(), [](const auto& a, const auto& b) {
    return a.real() != b.real() ? a.real() > b.real() : a.imag() > b.imag();
  });
}

double find_start(const Trajectory& trajectory, CoordinateId coordinate) {
  for (const CoordinateValue& value : trajectory.from.joints)
    if (value.coordinate == coordinate) return value.value;
  return 0;
}

bool is_same_question(const Trajectory& a, const Trajectory& b) {
  const auto is_same_pose = [](const std::vector<CoordinateValue>& x, const std::vector<CoordinateValue>& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(), [](const CoordinateValue& c, const CoordinateValue& d) {
      return c.coordinate == d.coordinate && c.value == d.value;
    });
  };
  if (a.free_motion->free != b.free_motion->free || !is_same_pose(a.from.joints, b.from.joints)) return false;
  const bool is_turning = a.law.kind == MotionLawKind::uniform;
  if (is_turning != (b.law.kind == MotionLawKind::uniform)) return false;
  if (!is_turning) return true;
  return std::equal(a.to.joints.begin(), a.to.joints.end(), b.to.joints.begin(), b.to.joints.end(),
                    [&](const CoordinateValue& c, const CoordinateValue& d) {
                      const double start = find_start(a, c.coordinate), first = (c.value - start) / a.duration,
                                   second = (d.value - start) / b.duration;
                      return c.coordinate == d.coordinate &&
                             std::abs(first - second) <= equal_eigenvalues * std::abs(first);
                    });
}

}  // namespace

double VibrationMode::frequency() const { return eigenvalue.imag() / (2 * std::numbers::pi); }

double VibrationMode::damping_ratio() const {
  const double size = std::abs(eigenvalue);
  return eigenvalue.real() != 0 ? -eigenvalue.real() / size : 0;
}

const char* name_of(Stability stability) {
  switch (stability) {
    case Stability::stable: return "stable";
    case Stability::marginal: return "marginal";
    case Stability::unstable: return "unstable";
  }
  return "";
}

Stability VibrationModes::stability() const {
  Stability stability = Stability::stable;
  for (const VibrationMode& mode : modes) {
    if (mode.eigenvalue.real() > 0) return Stability::unstable;
    if (mode.eigenvalue.real() == 0) stability = Stability::marginal;
  }
  return stability;
}

VibrationModes find_vibration_modes(const Mechanism& mechanism, const Trajectory* trajectory) {
  VibrationModes found;
  if (trajectory != nullptr) found.trajectory = trajectory->name;
  found.motion = linearise_motion(mechanism, trajectory);
  if (found.motion.outcome.status == MotionStatus::done) solve_modes(found);
  return found;
}

std::vector<VibrationModes> find_vibration_modes(const Study& study) {
  std::vector<VibrationModes> all;
  for (std::size_t t = 0; t < study.trajectories.size(); ++t) {
    const Trajectory& trajectory = study.trajectories[t];
    if (!trajectory.free_motion) continue;
    const auto end = study.trajectories.begin() + static_cast<std::ptrdiff_t>(t);
    if (std::any_of(study.trajectories.begin(), end,
                    [&](const Trajectory& other) { return other.free_motion && is_same_question(other, trajectory); }))
      continue;
    try {
      all.push_back(find_vibration_modes(study.mechanism, &trajectory));
    } catch (const std::invalid_argument& error) {
      VibrationModes failed;
      failed.trajectory = trajectory.name;
      failed.motion.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
      failed.motion.coordinates = trajectory.free_motion->free;
      all.push_back(std::move(failed));
    }
  }
  return all;
}

}  // namespace balance::vibration
