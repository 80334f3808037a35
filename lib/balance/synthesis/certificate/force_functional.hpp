#pragma once
/// Weighted sums of forces along a motion, for all lengths of a box, as functions of the masses that are free.
///
/// Inertia forces times a virtual motion are a virtual power: a weight of the shaking force is a virtual translation of
/// everything, one of the shaking moment a rotation about its point, one of a torque the motion that its actuator makes
/// while the others rest. A mass m at the place q of a body contributes m (c_m + c_d · q + c_J |q|²) with coefficients
/// that are those of a unit mass, first moment and moment of inertia at the body's origin.

#include "balance/synthesis/certificate/figure_problem.hpp"

#include <array>
#include <vector>

namespace balance::certificate {

/// Mass and place of an element, as far as they are fixed.
struct ElementEnclosure {
  IntervalJet mass;
  std::array<IntervalJet, 2> place;
};

/// The linkage without its free elements, and what is fixed of these.
struct LoadedLinkage {
  LinkageEnclosure linkage;
  std::vector<ElementEnclosure> elements;  ///< as in the problem
};

/// @param order of the derivatives by the lengths
/// @throws EnclosureError if a number of the mechanism has no enclosure
LoadedLinkage enclose_linkage(const DesignSpace& space, const FigureProblem& problem, const LengthBox& box, int order);

/// Weights of the forces at one moment; none if the force has no weight there.
struct ForceWeights {
  std::array<IntervalJet, 2> force{};
  IntervalJet moment;                ///< of the moment about the world's origin
  std::vector<IntervalJet> torques;  ///< per actuator; empty: none
};

class ForceFunctional {
 public:
  /// @param linkage must outlive this object
  ForceFunctional(const FigureProblem& problem, const LoadedLinkage& linkage);

  /// Adds a moment of the motion. @throws EnclosureError if the actuators do not determine the motion
  void add(MotionEnclosure& motion, const ForceWeights& weights);

  /// Of all that is not free.
  const IntervalJet& fixed() const { return fixed_; }
  /// c_m, c_d, c_J of an element's body.
  const std::array<IntervalJet, 4>& coefficients(std::size_t element) const {
    return carriers_[static_cast<std::size_t>(carrier_of_[element])].coefficients;
  }

 private:
  struct Carrier {
    kinematics::FixedFrame<IntervalPlane> frame;
    std::array<IntervalJet, 4> coefficients{};
  };
  /// A frame of a virtual and a real motion, in world axes.
  struct FrameMotion {
    IntervalPlane::Vector velocity, acceleration;
    IntervalJet rotation;  ///< virtual
    IntervalJet angular_acceleration, square;
  };
  void add_powers(const kinematics::TreeState<IntervalPlane>& state, bool has_weight);
  void add_frame(const FrameMotion& frame, const IntervalPlane::Vector& x_axis, std::array<IntervalJet, 4>& sums) const;

  const LoadedLinkage* linkage_;
  std::vector<int> carrier_of_;  ///< per element
  std::vector<Carrier> carriers_;
  IntervalJet fixed_;
  std::vector<IntervalPlane::Vector> velocities_;  ///< virtual, of the nodes' origins, world axes
  std::vector<IntervalJet> rotations_;             ///< virtual, of the nodes
};

}  // namespace balance::certificate
