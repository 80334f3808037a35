#pragma once
/// Generalised forces of weight, loads and springs on the unknowns. Private to natural.

#include "balance/natural/model.hpp"

namespace balance::natural {

/// A force with its moment about the world's origin, internal units.
struct NaturalWrench {
  Complex force;
  double moment = 0;
};

class AppliedForces {
 public:
  AppliedForces(const Mechanism& mechanism, const NaturalModel& model);

  /// Adds to one complex force per point: power Σ Re(conj(force) ż). Springs in joint coordinates are in add_joint_springs().
  /// @return what the loads do in all
  NaturalWrench add_forces(const NaturalCoordinates& position, double time, std::vector<Complex>& forces) const;
  /// Adds what springs in joint coordinates do to the scalars [kg length²/s²].
  void add_joint_springs(const NaturalCoordinates& position, double* scalars) const;
  /// Of weight and springs [kg length²/s²], zero where the weight's centre is at the world's origin.
  double energy(const NaturalCoordinates& position) const;
  /// Weight in all, at the centre of mass.
  NaturalWrench weight(const NaturalCoordinates& position) const;

 private:
  struct PlacedLoad {
    const Load* load;
    AffineForm point, direction;
  };
  struct PlacedSpring {
    AffineForm vector;  ///< from its first to its second end
    double stiffness, free_length;
  };

  struct JointSpring {
    ScalarAffineForm coordinate;  ///< [rad or m]
    double stiffness, preload;    ///< of an energy in kg length²/s²
  };

  const NaturalModel& model_;
  Complex gravity_;
  std::vector<PlacedLoad> loads_;
  std::vector<PlacedSpring> springs_;
  std::vector<JointSpring> joint_springs_;
};

/// M applied to rates or accelerations of the points: a momentum or a force per point, P3 eq. 22–23 before the sum.
std::vector<Complex> multiply_by_mass(const NaturalModel& model, const std::vector<Complex>& rates);

}  // namespace balance::natural
