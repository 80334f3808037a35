#pragma once
/// Measures the terms of a mechanism's forces: the recursions of mechanics/dynamics/tree_dynamics.hpp with lengths in place of vectors, so
/// that nothing cancels.
///
/// For a node with the terms' sizes p of its place, w of its angular velocity, α of its angular acceleration and a of its
/// acceleration, and inertia of mass m, first moments c and second moments J (the sizes of their own terms, too):
///
///     p = p_P + |r|    w = w_P + |q̇|    α = α_P + |q̈| + w_P |q̇|    a = a_P + (α_P + w_P²) |r| + …    a_0 = |g|
///     f = m a + (α + w²) c + Σ f_child     n = J (α + w²) + c a + Σ (n_child + |r| f_child)
///
/// A rate that is round-off itself, below round_off_factor of the rest scale, is no term: all that is made of it is round-off. It counts as
/// large as if it were that part of a term.
///
/// (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2002, ch. 3: a sum is off by a small multiple of the unit
/// round-off times the sum of its terms' magnitudes.)

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"

#include <vector>

namespace balance {

/// What rates and accelerations are measured by where all coordinates rest: those of one radian or characteristic length.
struct RestScale {
  double rate = 0;          ///< [1/s]
  double acceleration = 0;  ///< [1/s^2]
};

template <class S>
class TermMagnitudeRecorder {
 public:
  /// @param tree must outlive the meter
  /// @param about world point that moments are about
  /// @param rest of the motion
  TermMagnitudeRecorder(const Mechanism& mechanism, const Tree<S>& tree, const typename S::Vector& about,
                        const RestScale& rest);

  /// Measures at a moment and keeps the largest sizes.
  /// @param now after a SampleEvaluator has seen it: the state holds all poses
  /// @param seen what the observer found there
  /// @param multipliers per closure row, as Actuation::multipliers()
  /// @param mobility of the equations: errors of their solution grow with its inverse
  void sample(const TreeMotion<S>& now, const Sample& seen, const std::vector<double>& multipliers, double mobility);

  /// Largest sizes so far.
  const TermMagnitudes& magnitudes() const { return terms_; }
  /// Largest so far of what the sizes' round_off_factor is to be taken of: of what equations are solved for, more by their residual and by
  /// the inverse of the mobility.
  const TermMagnitudes& amplified_magnitudes() const { return grown_; }

 private:
  struct NodeMagnitudes {
    double mass = 0, first = 0, second = 0;  ///< of everything fixed to it
    double place = 0, turning = 0, turning_rate = 0, speed = 0, acceleration = 0;
    double force = 0, moment = 0;
  };

  double magnitude_of(double value, double scale) const;
  void compute_rate_magnitudes(const TreeMotion<S>& now);
  static ForceMagnitude inertial_magnitude(const NodeMagnitudes& node);
  void propagate_motion(const TreeMotion<S>& now);
  void read_motion(const Sample& seen);
  void compute_sums(const TreeMotion<S>& now);
  void propagate_forces(const TreeMotion<S>& now);
  void add_in_joints(const TreeMotion<S>& now, const Sample& seen);
  void add_closures(const TreeMotion<S>& now, const std::vector<double>& multipliers);
  void add_constraint_wrench(const TreeMotion<S>& now, const VelocityTerm<S>& term, double size);
  void read_transmitted(const TreeMotion<S>& now, const Sample& seen);
  double unit(CoordinateId coordinate) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  double gravity_, about_;
  ExternalForces<S> external_;
  FixedFrame<S> tool_;
  std::vector<NodeMagnitudes> nodes_;
  RestScale rest_scale_;
  double rest_fraction_ = round_off_factor;  ///< of the rest scale, there and then
  std::vector<double> dy_, ddy_;             ///< per tree coordinate: sizes of its rate and acceleration
  std::vector<double> tau_;                  ///< per tree coordinate
  std::vector<ForceMagnitude> external_sizes_;
  double rate_ = 0, rate_rate_ = 0;  ///< largest of any tree coordinate, lengths in characteristic lengths
  TermMagnitudes now_, terms_, grown_;
};

extern template class TermMagnitudeRecorder<Planar>;
extern template class TermMagnitudeRecorder<Spatial>;

}  // namespace balance
