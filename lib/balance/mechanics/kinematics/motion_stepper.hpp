#pragma once
/// Follows a compiled trajectory through time: predictor from the last configurations, Newton on closures and
/// prescribed quantities, then velocities and accelerations from the same factorised matrix.

#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/kinematics/singularity_monitor.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace balance::kinematics {

/// Report of an accepted step: smallest pivots of the equations' and of the monitored matrix at its end, distance
/// covered [rad, characteristic lengths], number of corrections.
struct StepReport {
  double pivot = 1, actuation_pivot = 1, distance = 0;
  int iterations = 0;
};

template <class S>
class MotionStepper {
 public:
  static constexpr int max_newton_iterations = 8;  ///< per configuration
  static constexpr double newton_residual_tolerance =
      1e-12;  ///< scaled residual below which one correction is the last
  /// Number of attempted steps, and of rate evaluations if something rolls, per thousandth of the motion, and how many
  /// are added at every stop. On the way into a singularity steps become ever shorter.
  static constexpr long max_evaluations = 500'000, evaluations_per_stop = 200;
  static constexpr double max_correction = 0.1;  ///< of a prediction, in radians or characteristic lengths

  /// @param tree, plan must outlive the stepper; the plan's outcome must be done. The stepper may reset the references
  ///        of the tree's spherical joints.
  MotionStepper(const Mechanism& mechanism, Tree<S>& tree, const CompiledTrajectory<S>& plan);

  /// Another matrix to be monitored, from begin() on; it must outlive the stepper.
  void set_regularity_monitor(RegularityMonitor<S>& monitor) {
    regularity_monitor_ = &monitor;
    singularity_monitor_.monitor_actuation(monitor);
  }

  /// Starts at time 0. As for advance(): on false, outcome() says why and the last good configuration is kept.
  bool begin();
  /// Advances to a later time in as many steps as needed to stay in the same assembly mode.
  bool advance(double time);
  /// Updates the accelerations to one side of the present time (advance() leaves those of the side `after`).
  void update_accelerations(trajectory::Side side);

  /// Adopts a step computed elsewhere (mechanics/lanes/lane_kernels.hpp) that this stepper would have accepted. Until
  /// synchronise(), only the coordinates and the monitored distances are up to date.
  void adopt_step(const CoordinateSample& next, const StepReport& report);
  /// Updates poses, velocities and the matrix at the instant adopted last.
  /// @param resume whether further steps start from there
  void synchronise(bool resume);
  /// Number of resets of spherical joints' references. Coordinates before and after a reset are not comparable.
  int reference_resets() const { return reference_resets_; }
  /// Columns on which the matrix depends.
  const std::vector<ColumnId>& matrix_columns() const { return matrix_columns_; }
  double residual_tolerance() const { return residual_tolerance_; }  ///< scaled residual that cannot be improved upon

  const double* y() const { return current_.y.data(); }
  const double* dy() const { return current_.dy.data(); }
  const double* ddy() const { return current_.ddy.data(); }
  double time() const { return current_.time; }
  double duration() const { return plan_.prescribed_motion->duration(); }  ///< of the whole motion [s]
  int iterations() const { return iterations_; }
  const MotionOutcome& outcome() const { return outcome_; }
  /// How near the motion has come to singularities so far, and which it has passed; see SingularityMonitor.
  std::vector<std::string> notes() { return singularity_monitor_.notes(); }
  const KinematicEquations<S>& equations() const { return equations_; }

  /// Whether every coordinate is prescribed, so that no equation has to be solved; state() then holds nothing.
  bool is_explicit() const { return is_explicit_; }
  /// Poses and angular velocities now; origins' velocities only if a closure slides; accelerations are scratch.
  TreeState<S>& state() { return state_; }
  const TreeState<S>& state() const { return state_; }

  /// Smallest singular value of the scaled matrix at the present configuration.
  double mobility();

 private:
  enum class StepResult {
    done,
    no_convergence,
    far_from_prediction,
    singular,  ///< or possibly so during the step
    evaluations_exhausted,
    actuation_singular  ///< the monitored matrix is singular, or possibly so during the step
  };

  StepResult step(double time);
  bool newton(VectorX& y);
  void predict(double time);
  bool integrate(double time);
  bool rates_at(double time, const VectorX& y, VectorX& dy);
  void differentiate(CoordinateSample& sample);
  StepResult check_step(const CoordinateSample& next);
  StepResult accept();
  bool store_matrices();
  void locate_singularity(StepResult attempt, double min_step);
  double step_distance(const CoordinateSample& next) const;
  bool reset_spherical_references(double limit);
  void set_explicit(double time);
  void explain_stop(StepResult attempt, double min_step);
  std::pair<MotionStatus, const char*> diagnose(StepResult attempt);

  const Mechanism& mechanism_;
  Tree<S>& tree_;
  const CompiledTrajectory<S>& plan_;
  KinematicEquations<S> equations_;
  bool is_explicit_ = false;
  bool has_velocity_closures_ = false;  ///< there are velocity-level closures
  long evaluations_left_ = max_evaluations;
  double budget_reset_time_ = 0;  ///< when evaluations_left_ is replenished [s]
  double residual_tolerance_;
  TreeState<S> state_;
  trajectory::DriveSample sample_;
  RegularityMonitor<S>* regularity_monitor_ = nullptr;
  std::vector<ColumnId> matrix_columns_;
  double pivot_threshold_ = numerics::singular_pivot_threshold;  ///< smallest pivot that counts as regular
  numerics::PivotExtrapolation motion_extrapolation_,
      actuation_extrapolation_;  ///< of the matrix that determines the motion; of the monitored one
  SingularityMonitor<S> singularity_monitor_;
  double distance_ = 0;         ///< distance of the step last checked [rad, characteristic lengths]
  double actuation_pivot_ = 1;  ///< of the monitored matrix, at the end of that step
  CoordinateSample current_, previous_, second_previous_, next_;
  int history_count_ = 0;             ///< how many of previous_, second_previous_ continue smoothly into current_
  double next_step_size_ = INFINITY;  ///< next step to attempt [s]
  int iterations_ = 0, reference_resets_ = 0;
  VectorX predicted_, trial_;
  std::vector<double> x_;      ///< right-hand side, then solution
  std::vector<double> rates_;  ///< dy at the configuration of the last Newton step
  MotionOutcome outcome_;
};

extern template class MotionStepper<Planar>;
extern template class MotionStepper<Spatial>;

}  // namespace balance::kinematics
