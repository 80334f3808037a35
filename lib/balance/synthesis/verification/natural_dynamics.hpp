#pragma once
/// Generalised forces of weight, loads and springs on the unknowns.

#include "balance/mechanics/trajectory/motion_sample.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"
#include "balance/synthesis/verification/natural_model.hpp"

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

/// Finds what natural coordinates know of a moving mechanism at one moment.
class NaturalSampleEvaluator {
 public:
  /// @param model must outlive the observer
  NaturalSampleEvaluator(const Mechanism& mechanism, const NaturalModel& model, int freedoms, const Vector3& about);

  /// Why the actuators do not fit the freedoms; empty if they do.
  const std::string& mismatch() const { return mismatch_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// @return false if the actuators do not hold the mechanism there
  bool observe(const NaturalStepper& stepper);
  const Sample& last() const { return seen_; }
  /// Constraints and actuated coordinates together: has full rank where the actuators hold the mechanism.
  MatrixX actuation_matrix(const NaturalKinematicEquations& equations, const NaturalCoordinates& position) const;

 private:
  void read_coordinates(const NaturalStepper& stepper);
  void read_momentum(const NaturalState& state);
  bool solve_efforts(const NaturalStepper& stepper);
  VectorX needed_forces(const NaturalStepper& stepper);

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  AppliedForces applied_;
  int freedoms_;
  Complex about_;
  AffineForm com_, tool_;
  std::string mismatch_;
  std::vector<std::string> notes_;
  std::vector<Complex> inertia_;  ///< M q̈ per point
  NaturalWrench loads_;
  Complex shaking_;  ///< Σ M q̈
  Vector3 point_;    ///< that moments are about
  Sample seen_;
};

}  // namespace balance::natural
