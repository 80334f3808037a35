#pragma once
/// Follows prescribed values over time: Taylor prediction, Newton on all equations, then velocities and accelerations.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/synthesis/verification/natural_model.hpp"

#include <functional>
#include <utility>

namespace balance::verification::natural {

// Prescribed quantities as rows in natural coordinates.

/// Rows whose values are the quantities in internal units; `unit` converts them to SI.
struct DriveRows {
  std::vector<ConstraintRow> rows;
  std::vector<double> unit;
};

/// In the order of DriveValue::value. The angles and coordinates must be scalars of the model.
DriveRows make_drive_rows(const Mechanism& mechanism, const NaturalModel& model,
                          const trajectory::DriveQuantities& quantities);

/// The CoM as a form: m · CoM = B M q (P3 eq. 21), divided by m.
AffineForm make_com_form(const NaturalModel& model);

AffineForm make_tool_form(const Mechanism& mechanism, const NaturalModel& model);

/// Constraints and prescribed quantities as one system, solved by Newton's method with dense factorisations.
class NaturalKinematicEquations {
 public:
  NaturalKinematicEquations(const NaturalModel& model, DriveRows drive);

  int unknown_count() const { return model_.unknowns(); }
  int constraint_count() const { return static_cast<int>(model_.constraints.size()); }
  int drive_row_count() const { return static_cast<int>(drive_.rows.size()); }
  int rows() const { return constraint_count() + drive_row_count(); }

  /// Left-hand sides minus prescribed values [SI, one per driven row].
  VectorX residual(const NaturalCoordinates& position, const VectorX& prescribed) const;
  MatrixX jacobian(const NaturalCoordinates& position) const;
  MatrixX constraint_jacobian(const NaturalCoordinates& position) const;
  /// Values of the driven rows [SI].
  VectorX measure(const NaturalCoordinates& position) const;
  VectorX measure_rate(const NaturalState& state) const;

  /// Newton's method with as many rows as unknowns (LU), or with more, consistent rows (least squares). The last
  /// correction follows a residual that is already small.
  /// @return false if it does not converge
  bool newton(NaturalCoordinates& position, const VectorX& prescribed);
  /// The same with minimum-norm corrections and any number of rows: for start configurations.
  bool solve_least_norm(NaturalCoordinates& position, const VectorX& prescribed) const;
  /// Computes velocities and accelerations; factorises the matrix at the state's position.
  bool differentiate(NaturalState& state, const trajectory::DriveSample& sample);
  /// Recomputes accelerations with the current factorisation.
  void accelerate(NaturalState& state, const trajectory::DriveSample& sample) const;

  /// Velocities per unit rate of the driven rows: they span what the constraints allow. Uses the last factorisation.
  MatrixX allowed_velocities() const;
  int iterations() const { return iterations_; }

 private:
  bool factorise(const NaturalCoordinates& position);
  VectorX solve(const VectorX& right_hand_side) const;

  const NaturalModel& model_;
  DriveRows drive_;
  bool square_;
  Eigen::PartialPivLU<MatrixX> lu_;
  numerics::ColumnPivotingQr qr_;
  int iterations_ = 0;
  double residual_tolerance_;
};

/// Number of independent constraints: the maximum at a few configurations around one that meets them.
int find_generic_constraint_rank(const NaturalModel& model, const NaturalCoordinates& position);

class NaturalStepper {
 public:
  /// @param model, schedule must outlive the stepper
  NaturalStepper(const NaturalModel& model, DriveRows drive, const trajectory::PrescribedMotion& schedule,
                 int freedoms);

  /// Sets another matrix that must keep full column rank from begin() on.
  void set_actuation_matrix(std::function<MatrixX(const NaturalCoordinates&)> matrix) {
    actuation_matrix_ = std::move(matrix);
  }
  /// Starts at time 0, from a configuration near the start. As for advance(): if it returns false, outcome() says why,
  /// and the last good state remains.
  bool begin(const NaturalCoordinates& initial_position);
  /// Advances to a later time, in as many steps as necessary to stay in the same assembly mode.
  bool advance(double time);
  /// Computes accelerations on one side of the current time (advance() leaves those of the side `after`).
  void accelerate(trajectory::Side side);

  double time() const { return state_.time; }
  double duration() const { return schedule_.duration(); }  ///< of the whole motion [s]
  const NaturalState& state() const { return state_; }
  /// Angle of every body, continuous beyond ±π [rad], and its rates; from the scalars or the directions.
  const std::vector<double>& angles() const { return angles_; }
  double angular_velocity(BodyId body) const;
  double angular_acceleration(BodyId body) const;
  int iterations() const { return iterations_; }
  const NaturalKinematicEquations& equations() const { return equations_; }
  const MotionOutcome& outcome() const { return outcome_; }

 private:
  enum class StepResult { done, no_convergence, far_from_prediction, possible_rank_loss, actuation_singular };

  StepResult step(double time);
  StepResult check_step(const NaturalState& next);
  double curvature(const NaturalState& next) const;
  bool is_far_from_prediction(const NaturalCoordinates& predicted, const NaturalCoordinates& corrected) const;
  void update_angles(const std::vector<double>& expected);
  void stop(StepResult attempt);

  const NaturalModel& model_;
  const trajectory::PrescribedMotion& schedule_;
  int freedoms_;
  NaturalKinematicEquations equations_;
  NaturalState state_;
  std::vector<double> angles_;
  trajectory::DriveSample sample_;
  int iterations_ = 0;
  numerics::RankMonitor constraint_monitor_, actuation_monitor_;
  numerics::PivotExtrapolation pivot_extrapolation_, actuation_extrapolation_;
  std::function<MatrixX(const NaturalCoordinates&)> actuation_matrix_;
  MotionOutcome outcome_;
};

}  // namespace balance::verification::natural
