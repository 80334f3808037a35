#pragma once
/// Free vibrations: modes of the linear motion of free coordinates about an equilibrium or a steady motion.

#include "balance/motion/study/study.hpp"
#include "balance/motion/vibration/linear_motion.hpp"

#include <complex>
#include <string>
#include <vector>

namespace balance::vibration {

/// A solution δ = Re(shape · e^(λt)) of the linear equations: an oscillation if λ has an imaginary part (which is then
/// positive), else a decay or, if λ > 0, growth.
struct VibrationMode {
  std::complex<double> eigenvalue;  ///< λ [1/s]
  /// Per coordinate [m or rad]; the largest entry, in characteristic lengths or radians, is 1.
  Eigen::VectorXcd shape;

  bool oscillates() const { return eigenvalue.imag() > 0; }
  double frequency() const;      ///< of the damped oscillation [Hz]
  double damping_ratio() const;  ///< −Re λ / |λ|; 0 for λ = 0
};

/// stable: every deviation decays. marginal: none grows, but for rigid motions, which may drift.
enum class Stability { stable, marginal, unstable };
const char* name_of(Stability stability);

/// Of one trajectory.
struct VibrationModes {
  std::string trajectory;            ///< empty: the mechanism as assembled
  LinearMotion motion;               ///< its outcome says why there are no modes
  std::vector<VibrationMode> modes;  ///< by increasing |λ|; rigid motion has λ = 0, twice
  /// All eigenvalues, by decreasing real part; but for those of rigid motions, nothing is rounded.
  std::vector<std::complex<double>> eigenvalues;

  Stability stability() const;
};

/// Modes of coefficients that are constant or averaged.
VibrationModes find_vibration_modes(const Mechanism& mechanism, const Trajectory* trajectory);

/// One entry for every trajectory of the study with free coordinates; of several with the same free coordinates and
/// driven motion at the start, the first. Errors are outcomes.
std::vector<VibrationModes> find_vibration_modes(const Study& study);

}  // namespace balance::vibration
