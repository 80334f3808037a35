#pragma once
/// Generalised forces of weight, loads, springs and dampers on the unknowns.

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/mechanics/model/load_table.hpp"
#include "balance/mechanics/model/torque_distribution.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"
#include "balance/synthesis/verification/natural_model.hpp"

namespace balance::verification::natural {

/// A force and its moment about the world's origin, in internal units.
struct NaturalWrench {
  Complex force;
  double moment = 0;
};

/// A force over a displacement in SI units, read from its table without the other formulation's coefficients.
class TableReader {
 public:
  explicit TableReader(const model::ForceTableOf<double>& table);
  double force(double displacement) const;
  double energy(double displacement) const;  ///< from the first row [J]

 private:
  model::ForceTableOf<double> table_;
  std::optional<numerics::CubicSpline> spline_;
};

class AppliedForces {
 public:
  AppliedForces(const Mechanism& mechanism, const NaturalModel& model);

  /// Adds to one complex force per point; power is Σ Re(conj(force) ż). For joint springs, see add_joint_springs().
  /// @return the resultant of the loads
  NaturalWrench add_forces(const NaturalCoordinates& position, const NaturalCoordinates& velocity, double time,
                           std::vector<Complex>& forces) const;
  /// Adds the generalised forces of joint springs to the scalars [kg length²/s²].
  void add_joint_springs(const NaturalCoordinates& position, double* scalars) const;
  /// Potential energy of weight and springs [kg length²/s²]; that of weight is zero with the CoM at the world's origin.
  double energy(const NaturalCoordinates& position) const;
  /// Total weight, at the CoM.
  NaturalWrench weight(const NaturalCoordinates& position) const;

 private:
  struct PlacedLoad {
    model::LoadTable<double> table;
    const ScalarAffineForm* coordinate;  ///< the table's argument; null: the time
    AffineForm point, direction;
  };
  struct PlacedSpring {
    AffineForm vector;  ///< from its first to its second end
    Spring law;         ///< lengths in units of the model's length
  };

  struct JointSpring {
    ScalarAffineForm coordinate;  ///< [rad or m]
    double stiffness, preload;    ///< in units of an energy in kg length²/s²
  };

  /// A damper, or a spring with a table, between points.
  struct PointElement {
    AffineForm vector;  ///< from its first to its second end
    const ForceElement* element;
    TableReader table;
  };
  struct JointTable {
    ScalarAffineForm coordinate;  ///< [rad or m]
    TableReader table;
  };

  const NaturalModel& model_;
  Complex gravity_;
  std::vector<PlacedLoad> loads_;
  std::vector<PlacedSpring> springs_;
  std::vector<JointSpring> joint_springs_;
  std::vector<PointElement> point_elements_;
  std::vector<JointTable> joint_tables_;
};

/// M applied to rates or accelerations of the points: one momentum or force per point, P3 eq. 22–23 before summation.
std::vector<Complex> multiply_by_mass(const NaturalModel& model, const std::vector<Complex>& rates);

/// Evaluates the quantities of a moving mechanism at one instant from natural coordinates.
class NaturalSampleEvaluator {
 public:
  /// @param model must outlive this object
  NaturalSampleEvaluator(const Mechanism& mechanism, const NaturalModel& model, int freedoms, const Vector3& about);

  /// Why the actuators do not match the freedoms; empty if they do.
  const std::string& mismatch() const { return mismatch_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// @return false if the actuators do not hold the mechanism there
  bool observe(const NaturalStepper& stepper);
  const Sample& last() const { return sample_; }
  /// Constraints and actuated coordinates together: has full rank if the actuators hold the mechanism.
  MatrixX actuation_matrix(const NaturalKinematicEquations& equations, const NaturalCoordinates& position) const;

 private:
  void update_coordinates(const NaturalStepper& stepper);
  void update_momentum(const NaturalState& state);
  bool solve_efforts(const NaturalStepper& stepper);
  VectorX required_forces(const NaturalStepper& stepper);

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  AppliedForces applied_forces_;
  int freedoms_;
  Complex about_;
  AffineForm com_, tool_;
  std::string mismatch_;
  std::vector<std::string> notes_;
  std::optional<model::ScaledDistribution<double>> distribution_;  ///< of redundant actuators; none: least norm
  std::vector<Complex> inertial_forces_;                           ///< M q̈ per point
  NaturalWrench load_wrench_;
  Complex shaking_;           ///< Σ M q̈
  Vector3 moment_reference_;  ///< reference point of moments
  Sample sample_;
};

}  // namespace balance::verification::natural
