#include "balance/synthesis/verification/vibration_modes.hpp"

#include "balance/motion/simulation/free_motion.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace balance::verification {

namespace {

/// Eigenvalues below this fraction of the largest one are round-off. A double eigenvalue is known to half of the digits.
constexpr double eigenvalue_round_off = 1e-6;

/// With eigenvalues in units of the largest rate, so that coordinates and rates are of the same size.
std::vector<VibrationMode> solve_modes(const simulation::LinearisedFreeMotion& motion) {
  const Eigen::Index n = motion.position.size();
  const VectorX inverse_unit = motion.unit.cwiseInverse();
  const MatrixX stiffness = inverse_unit.asDiagonal() * motion.stiffness * motion.unit.asDiagonal(),
                damping = inverse_unit.asDiagonal() * motion.damping * motion.unit.asDiagonal();
  const double rate = std::max(std::sqrt(stiffness.norm()), damping.norm());
  MatrixX system = MatrixX::Zero(2 * n, 2 * n);
  system.topRightCorner(n, n).setIdentity();
  if (rate > 0) {
    system.bottomLeftCorner(n, n) = stiffness / (rate * rate);
    system.bottomRightCorner(n, n) = damping / rate;
  }
  const Eigen::EigenSolver<MatrixX> solver(system);
  std::vector<VibrationMode> modes;
  for (Eigen::Index k = 0; k < 2 * n; ++k) {
    std::complex<double> value = solver.eigenvalues()[k];
    if (std::abs(value) <= eigenvalue_round_off) value = 0;
    if (value.imag() < 0) continue;  // the conjugate of another
    Eigen::VectorXcd shape = solver.eigenvectors().col(k).head(n);
    std::complex<double> largest = 0;
    for (const std::complex<double> entry : shape)
      if (std::abs(entry) > std::abs(largest)) largest = entry;
    shape /= largest;
    modes.push_back({rate * value, shape.cwiseProduct(motion.unit)});
  }
  std::stable_sort(modes.begin(), modes.end(), [](const VibrationMode& a, const VibrationMode& b) {
    return std::abs(a.eigenvalue) < std::abs(b.eigenvalue);
  });
  return modes;
}

bool is_same_question(const Trajectory& a, const Trajectory& b) {
  if (a.free_motion->free != b.free_motion->free || a.from.joints.size() != b.from.joints.size()) return false;
  return std::equal(a.from.joints.begin(), a.from.joints.end(), b.from.joints.begin(),
                    [](const CoordinateValue& x, const CoordinateValue& y) {
                      return x.coordinate == y.coordinate && x.value == y.value;
                    });
}

}  // namespace

double VibrationMode::frequency() const { return eigenvalue.imag() / (2 * std::numbers::pi); }

double VibrationMode::damping_ratio() const {
  const double size = std::abs(eigenvalue);
  return size > 0 ? -eigenvalue.real() / size : 0;
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
    VibrationModes found{trajectory.name, {}, trajectory.free_motion->free, {}, {}};
    try {
      const simulation::LinearisedFreeMotion motion = simulation::linearise_free_motion(study.mechanism, trajectory);
      found.outcome = motion.outcome;
      found.position = motion.position;
      if (motion.outcome.status == MotionStatus::done) found.modes = solve_modes(motion);
    } catch (const std::invalid_argument& error) {
      found.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
    }
    all.push_back(std::move(found));
  }
  return all;
}

}  // namespace balance::verification
