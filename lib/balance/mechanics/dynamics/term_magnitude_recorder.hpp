#pragma once
/// Measures the magnitudes of the terms of a mechanism's forces: the recursions of mechanics/dynamics/tree_dynamics.hpp
/// with magnitudes in place of vectors, so that nothing cancels.
///
/// For a node with term magnitudes p of its position, w of its angular velocity, α of its angular acceleration and a of
/// its acceleration, and with mass m, first moments c and second moments J (term magnitudes, too):
///
///     p = p_P + |r|    w = w_P + |q̇|    α = α_P + |q̈| + w_P |q̇|    a = a_P + (α_P + w_P²) |r| + …    a_0 = |g|
///     f = m a + (α + w²) c + Σ f_child     n = J (α + w²) + c a + Σ (n_child + |r| f_child)
///
/// A rate below round_off_factor of the rest scale is itself round-off, and so is everything computed from it. It
/// counts as if it were that fraction of a term.
///
/// (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2002, ch. 3: the error of a sum is a small multiple
/// of the unit round-off times the sum of its terms' magnitudes.)

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"

#include <vector>

namespace balance::dynamics {

/// Scale of rates and accelerations if all coordinates rest: those of one radian or characteristic length.
struct RestScale {
  double rate = 0;          ///< [1/s]
  double acceleration = 0;  ///< [1/s^2]
};

template <class S>
class TermMagnitudeRecorder {
 public:
  /// @param tree must outlive the recorder
  /// @param about world point about which moments are taken
  /// @param rest scale of the motion
  TermMagnitudeRecorder(const Mechanism& mechanism, const kinematics::Tree<S>& tree, const typename S::Vector& about,
                        const RestScale& rest);

  /// Measures at an instant and keeps the maximum magnitudes.
  /// @param motion evaluated by a SampleEvaluator: the state holds all poses
  /// @param sample the sample found there
  /// @param multipliers per closure row, as Actuation::multipliers()
  /// @param mobility of the equations: errors of their solution grow with its inverse
  void sample(const TreeMotion<S>& motion, const Sample& sample, const std::vector<double>& multipliers,
              double mobility);

  /// Maximum magnitudes so far.
  const results::TermMagnitudes& magnitudes() const { return terms_; }
  /// Maximum so far of the magnitudes to which round_off_factor applies: those of solved quantities are amplified
  /// according to the equations' residual and the inverse of the mobility.
  const results::TermMagnitudes& amplified_magnitudes() const { return amplified_; }

 private:
  struct NodeMagnitudes {
    double mass = 0, first = 0, second = 0;  ///< of everything fixed to it
    double distance = 0, angular_velocity = 0, angular_acceleration = 0, speed = 0, acceleration = 0;
    double force = 0, moment = 0;
  };

  double magnitude_of(double value, double scale) const;
  void compute_rate_magnitudes(const TreeMotion<S>& motion);
  static ForceMagnitude inertial_magnitude(const NodeMagnitudes& node);
  void propagate_motion(const TreeMotion<S>& motion);
  void read_motion(const Sample& sample);
  void compute_sums(const TreeMotion<S>& motion);
  void propagate_forces(const TreeMotion<S>& motion);
  void add_in_joints(const TreeMotion<S>& motion, const Sample& sample);
  void add_closures(const TreeMotion<S>& motion, const std::vector<double>& multipliers);
  void add_constraint_wrench(const TreeMotion<S>& motion, const kinematics::VelocityTerm<S>& term, double magnitude);
  void read_transmitted(const TreeMotion<S>& motion, const Sample& sample);
  double unit(CoordinateId coordinate) const;

  const Mechanism& mechanism_;
  const kinematics::Tree<S>& tree_;
  double gravity_, about_;
  ExternalForces<S> external_;
  kinematics::FixedFrame<S> tool_;
  std::vector<NodeMagnitudes> nodes_;
  RestScale rest_scale_;
  double rest_fraction_ = results::round_off_factor;  ///< of the rest scale, at the present instant
  std::vector<double> dy_, ddy_;                      ///< per tree coordinate: magnitudes of its rate and acceleration
  std::vector<double> tau_;                           ///< per tree coordinate
  std::vector<ForceMagnitude> external_magnitudes_;
  double max_rate_ = 0, max_acceleration_ = 0;  ///< largest of any tree coordinate, lengths in characteristic lengths
  results::TermMagnitudes current_, terms_, amplified_;
};

extern template class TermMagnitudeRecorder<kinematics::Planar>;
extern template class TermMagnitudeRecorder<kinematics::Spatial>;

}  // namespace balance::dynamics
