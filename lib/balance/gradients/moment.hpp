#pragma once
/// One moment of a motion with its derivatives. Newton's iteration is never differentiated: where the equations f(y, p) = 0 were solved
/// over doubles, one evaluation over duals and one solution with the matrix A = ∂f/∂y, which is factorised once, give dy = −A⁻¹ ∂f/∂p
/// (implicit function theorem); rates and accelerations follow from their own equations in the same way. Private to gradients.

#include "balance/dynamics/observer.hpp"
#include "balance/gradients/joint_opening.hpp"
#include "balance/gradients/over_duals.hpp"

#include <array>
#include <vector>

namespace balance {

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

  /// For whoever changes what it carries.
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

}  // namespace balance
