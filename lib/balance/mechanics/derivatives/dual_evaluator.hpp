#pragma once
/// Evaluates one instant of a motion together with its derivatives. Newton's iteration itself is not differentiated:
/// once the equations f(y, p) = 0 have been solved in double precision, one evaluation with dual numbers and one solve
/// with A = ∂f/∂y, factorised once, give dy = −A⁻¹ ∂f/∂p (implicit function theorem). Rates and accelerations follow
/// from their own equations in the same way.

#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/derivatives/mechanism_variables.hpp"
#include "balance/mechanics/derivatives/state_gradient.hpp"
#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/space.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"

#include <array>
#include <vector>

namespace balance::derivatives {

// The engine over dual numbers: its spaces, and the conversion of values to constants.

using DualNumber = Dual<numerics::dual_width>;

template <class S>
struct DualSpaceOf;
template <>
struct DualSpaceOf<kinematics::Planar> {
  using Type = kinematics::PlanarOf<DualNumber>;
};
template <>
struct DualSpaceOf<kinematics::Spatial> {
  using Type = kinematics::SpatialOf<DualNumber>;
};
template <class S>
using DualSpace = typename DualSpaceOf<S>::Type;

/// The mechanism with zero derivatives; seed those of the requested variables: `m.bodies[1].mass.d[0] = 1`.
inline MechanismOf<DualNumber> to_dual(const Mechanism& mechanism) {
  return model::convert_mechanism<DualNumber>(mechanism, [](double x) { return DualNumber(x); });
}

inline TrajectoryOf<DualNumber> to_dual(const Trajectory& trajectory) {
  return trajectory::cast_scalar<DualNumber>(trajectory, [](double x) { return DualNumber(x); });
}

/// Which part of a sample to differentiate.
enum class DerivativeDetail {
  forces,   ///< time, efforts, powers, shaking and ground forces and moments, acceleration of the centre of mass
  figures,  ///< also all other quantities that have figures
  all,
};

/// Writes the derivatives with respect to variable k into the fields of the corresponding values. Counts and fields
/// that only controlled runs fill are left unchanged. Reuses the memory of `out`.
void write_derivative(const trajectory::SampleOf<DualNumber>& sample, std::size_t k, DerivativeDetail detail,
                      Sample& out);
Sample derivative_of(const trajectory::SampleOf<DualNumber>& sample, std::size_t k);

/// y, dy and ddy per tree coordinate.
struct DualCoordinates {
  VectorXOf<DualNumber> y, dy, ddy;
};

template <class S>
class DualEvaluator {
 public:
  using D = DualSpace<S>;

  /// @param mechanism, tree must outlive the evaluator; the tree is compiled from the mechanism's values
  /// @param needed coordinates that the tree was compiled with
  /// @param redundant whether the closures have more rows than rank @param about world point about which moments are
  ///        taken
  DualEvaluator(const MechanismOf<DualNumber>& mechanism, const kinematics::Tree<S>& tree,
                const std::vector<CoordinateId>& needed, const trajectory::DriveQuantities& quantities, bool redundant,
                int freedoms, const typename D::Vector& about);

  /// Differentiates the configuration, rates and accelerations that the target prescribes.
  /// @param y tree coordinates that meet the target's values to round-off, with the tree's present references
  void differentiate_motion(const double* y, const trajectory::DriveSampleOf<DualNumber>& target);
  /// Evaluates the whole sample at this instant. @param duration of the whole motion [s], for the rest threshold of
  /// friction
  /// @return false if the actuators do not hold the mechanism
  bool evaluate(const DualNumber& time, double duration, dynamics::Detail detail);

  /// Mutable, so that payloads can be attached and detached.
  kinematics::Tree<D>& tree() { return tree_; }
  const DualCoordinates& coordinates() const { return coordinates_; }
  trajectory::SampleOf<DualNumber>& sample() { return sample_evaluator_.sample(); }
  /// Smallest singular value of the scaled equations; 1 if nothing has to be solved.
  DualNumber mobility();
  /// Largest gaps that variable k opens, over all calls of differentiate_motion().
  ClosureGaps closure_gaps(std::size_t k) const;

 private:
  using DualArray = std::array<double, numerics::dual_width>;
  struct Gap {
    DualArray length{}, angle{};
  };

  void differentiate_explicit(const trajectory::DriveSampleOf<DualNumber>& target);
  DualArray max_residual_change(int count) const;
  void measure_gaps(const DualArray& initial_change);

  const kinematics::Tree<S>& values_;
  kinematics::Tree<D> tree_;
  kinematics::Drive<D> drive_;
  kinematics::KinematicEquations<D> equations_;
  dynamics::SampleEvaluator<D> sample_evaluator_;
  kinematics::TreeState<D> state_;
  bool is_explicit_;
  std::vector<Gap> gaps_;  ///< per closure; empty unless there are more rows than rank
  DualCoordinates coordinates_;
  std::vector<DualNumber> x_;
};

extern template class DualEvaluator<kinematics::Planar>;
extern template class DualEvaluator<kinematics::Spatial>;

// Derivatives of one state with respect to variables on which the mechanism's own numbers depend.

/// As differentiate_state(), with respect to the variables that `mechanism` is seeded with.
/// @param mechanism over dual numbers, with the values of inverse_dynamics.mechanism() @return dual_width derivatives
Expected<StateGradient> derivatives(InverseDynamics& inverse_dynamics, const MechanismOf<DualNumber>& mechanism,
                                    const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

}  // namespace balance::derivatives
