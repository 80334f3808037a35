#pragma once
/// Free vibrations of partly driven mechanisms, linearised about an equilibrium.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/study/study.hpp"

#include <complex>
#include <string>
#include <vector>

namespace balance::verification {

/// A solution δ = Re(shape · e^(λt)) of the linear equations: an oscillation if λ has an imaginary part (which is then
/// positive), else a decay or, if λ > 0, growth.
struct VibrationMode {
  std::complex<double> eigenvalue;  ///< λ [1/s]
  /// Per free coordinate [m or rad]; the largest entry, in characteristic lengths or radians, is 1.
  Eigen::VectorXcd shape;

  bool oscillates() const { return eigenvalue.imag() > 0; }
  double frequency() const;      ///< of the damped oscillation [Hz]
  double damping_ratio() const;  ///< −Re λ / |λ|; 0 for λ = 0
};

/// Of one trajectory with free coordinates.
struct VibrationModes {
  std::string trajectory;
  MotionOutcome outcome;  ///< done, or why there is no equilibrium
  std::vector<CoordinateId> free;
  VectorX position;                  ///< of the free coordinates at the equilibrium
  std::vector<VibrationMode> modes;  ///< by increasing |λ|; rigid motion has λ = 0, twice
};

/// One entry for every trajectory of the study with free coordinates; of several with the same free coordinates and
/// driven start, the first.
std::vector<VibrationModes> find_vibration_modes(const Study& study);

}  // namespace balance::verification
