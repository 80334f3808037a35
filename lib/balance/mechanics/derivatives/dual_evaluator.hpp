#pragma once
/// One moment of a motion with its derivatives. Newton's iteration is never differentiated: where the equations f(y, p) = 0 were solved
/// over doubles, one evaluation over duals and one solution with the matrix A = ∂f/∂y, which is factorised once, give dy = −A⁻¹ ∂f/∂p
/// (implicit function theorem); rates and accelerations follow from their own equations in the same way.

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

namespace balance {

// The engine over numbers with derivatives: its spaces, and values turned into constants of them.

using DualNumber = Dual<dual_width>;

template <class S>
struct DualSpaceOf;
template <>
struct DualSpaceOf<Planar> {
  using Type = PlanarOf<DualNumber>;
};
template <>
struct DualSpaceOf<Spatial> {
  using Type = SpatialOf<DualNumber>;
};
template <class S>
using DualSpace = typename DualSpaceOf<S>::Type;

/// The mechanism with derivatives of zero; set those of the numbers wanted: `m.bodies[1].mass.d[0] = 1`.
inline MechanismOf<DualNumber> to_dual(const Mechanism& mechanism) {
  return convert_mechanism<DualNumber>(mechanism, [](double x) { return DualNumber(x); });
}

inline TrajectoryOf<DualNumber> to_dual(const Trajectory& trajectory) {
  return cast_scalar<DualNumber>(trajectory, [](double x) { return DualNumber(x); });
}

/// How much of a sample.
enum class DerivativeDetail {
  forces,   ///< time, efforts, powers, shaking and ground forces and moments, acceleration of the centre of mass
  figures,  ///< everything else, too, that has figures
  all,
};

/// Derivatives with respect to number k, each where the sample has the value. Counts and what only runs under control know are left
/// alone. Keeps the memory that `out` has.
void write_derivative(const SampleOf<DualNumber>& sample, std::size_t k, DerivativeDetail extent, Sample& out);
Sample derivative_of(const SampleOf<DualNumber>& sample, std::size_t k);

/// y, dy and ddy per tree coordinate.
struct DualCoordinates {
  VectorXOf<DualNumber> y, dy, ddy;
};

template <class S>
class DualEvaluator {
 public:
  using D = DualSpace<S>;

  /// @param mechanism, tree must outlive the moment; the tree is that of the mechanism's values
  /// @param needed as the tree was compiled with
  /// @param redundant more closure rows than rank @param about world point of moments
  DualEvaluator(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree, const std::vector<CoordinateId>& needed,
                const DriveQuantities& quantities, bool redundant, int freedoms, const typename D::Vector& about);

  /// Differentiates the configuration, rates and accelerations that the target prescribes.
  /// @param y meets the target's values to round-off, with the tree's present references
  void differentiate_motion(const double* y, const DriveSampleOf<DualNumber>& target);
  /// Everything there. @param duration of the whole motion [s], as friction asks
  /// @return false if the actuators do not hold the mechanism
  bool evaluate(const DualNumber& time, double duration, Detail detail);

  /// For changes of what it carries.
  Tree<D>& tree() { return tree_; }
  const DualCoordinates& coordinates() const { return now_; }
  SampleOf<DualNumber>& sample() { return observer_.sample(); }
  /// Smallest singular value of the scaled equations; 1 where nothing has to be solved.
  DualNumber mobility();
  /// What number k opens, where it is most of all places that move() was called for.
  ClosureGaps closure_gaps(std::size_t k) const;

 private:
  using DualArray = std::array<double, dual_width>;
  struct Gap {
    DualArray length{}, angle{};
  };

  void differentiate_explicit(const DriveSampleOf<DualNumber>& target);
  DualArray max_residual_change(int count) const;
  void measure_gaps(const DualArray& followed);

  const Tree<S>& values_;
  Tree<D> tree_;
  Drive<D> drive_;
  KinematicEquations<D> equations_;
  SampleEvaluator<D> observer_;
  TreeState<D> state_;
  bool direct_;
  std::vector<Gap> gaps_;  ///< per closure; empty unless there are more rows than rank
  DualCoordinates now_;
  std::vector<DualNumber> x_;
};

extern template class DualEvaluator<Planar>;
extern template class DualEvaluator<Spatial>;

// One state's derivatives by numbers that the mechanism's own depend on.

/// As derivatives() by numbers of the mechanism.
/// @param mechanism over duals, with the values of the door's mechanism @return dual_width derivatives
Expected<StateGradient> derivatives(InverseDynamics& door, const MechanismOf<DualNumber>& mechanism, const VectorX& q,
                                    const VectorX& dq, const VectorX& ddq, double time = 0);

}  // namespace balance
