#pragma once
/// Follows a plan through time: predictor from the last configurations, Newton on closures and prescribed quantities,
/// then velocities and accelerations from the same factorised matrix.

#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/kinematics/singularity_monitor.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// How an accepted step went: smallest pivots of the equations' and the guarded matrix at its end, how far it turned the mechanism
/// [rad, characteristic lengths], corrections.
struct StepReport {
  double pivot = 1, actuation_pivot = 1, distance = 0;
  int iterations = 0;
};

template <class S>
class MotionStepper {
 public:
  static constexpr int max_newton_iterations = 8;  ///< for one configuration, at most
  static constexpr double newton_residual_tolerance =
      1e-12;  ///< scaled residual after which one correction is the last
  /// Tried steps, and where something rolls evaluations of rates, for a thousandth of the motion, and how many more with every stop: on
  /// the way into a singularity steps become shorter without end.
  static constexpr long max_evaluations = 500'000, evaluations_per_stop = 200;
  static constexpr double max_correction = 0.1;  ///< of a prediction, in radians or characteristic lengths

  /// @param tree, plan must outlive the stepper; the plan must be done. The stepper may rereference the tree's spherical joints.
  MotionStepper(const Mechanism& mechanism, Tree<S>& tree, const CompiledTrajectory<S>& plan);

  /// Another matrix to be watched, from begin() on; it must outlive the stepper.
  void set_regularity_monitor(RegularityMonitor<S>& guard) {
    guard_ = &guard;
    singularity_monitor_.monitor_actuation(guard);
  }

  /// Time 0. Also true of advance: on false outcome() says why, and the last good configuration stays.
  bool begin();
  /// On to a later time, in as many steps as it takes to stay on the same assembly mode.
  bool advance(double time);
  /// Accelerations on one side of the present time (advance() leaves those of the side `after`).
  void update_accelerations(Side side);

  /// A step to a moment that was found elsewhere (mechanics/lanes/lane_kernels.hpp), which this stepper would have accepted. Only the
  /// moment and what is told of the way go on, until synchronise().
  void adopt_step(const CoordinateSample& next, const StepReport& measures);
  /// Poses, velocities and the matrix at a moment followed to. @param keep and the next steps go on from there
  void synchronise(bool keep);
  /// How often coordinates began to be counted from other references, so that those before and after are not comparable.
  int reference_resets() const { return references_; }
  /// Columns on which the matrix depends.
  const std::vector<ColumnId>& matrix_columns() const { return matrix_columns_; }
  double residual_tolerance() const { return round_off_; }  ///< scaled residual that cannot be improved upon

  const double* y() const { return now_.y.data(); }
  const double* dy() const { return now_.dy.data(); }
  const double* ddy() const { return now_.ddy.data(); }
  double time() const { return now_.time; }
  double duration() const { return plan_.prescribed_motion->duration(); }  ///< of the whole motion [s]
  int iterations() const { return iterations_; }
  const MotionOutcome& outcome() const { return outcome_; }
  /// How near the way so far has come to singularities, and what it has passed; see SingularityMonitor.
  std::vector<std::string> notes() { return singularity_monitor_.notes(); }
  const KinematicEquations<S>& equations() const { return equations_; }

  /// No equation has to be solved: every coordinate is prescribed. Then state() holds nothing.
  bool is_explicit() const { return direct_; }
  /// Poses and angular velocities now; origins' velocities only if a closure slides; accelerations are scratch.
  TreeState<S>& state() { return state_; }

  /// Smallest singular value of the scaled matrix at the present configuration.
  double mobility();

 private:
  enum class StepResult {
    done,
    no_convergence,
    far_from_prediction,    ///< from what was predicted
    singular,               ///< or may have been on the way
    evaluations_exhausted,  ///< all evaluations
    actuation_singular      ///< the guarded matrix is singular or may have been
  };

  StepResult step(double time);
  bool newton(VectorX& y);
  void predict(double time);
  bool integrate(double time);
  bool rates_at(double time, const VectorX& y, VectorX& dy);
  void differentiate(CoordinateSample& moment);
  StepResult check_step(const CoordinateSample& next);
  StepResult accept();
  bool store_matrices();
  void locate_singularity(StepResult attempt, double smallest);
  double step_distance(const CoordinateSample& next) const;
  bool reset_spherical_references(double limit);
  void set_explicit(double time);
  void explain_stop(StepResult attempt, double smallest);
  std::pair<MotionStatus, const char*> diagnose(StepResult attempt);

  const Mechanism& mechanism_;
  Tree<S>& tree_;
  const CompiledTrajectory<S>& plan_;
  KinematicEquations<S> equations_;
  bool direct_ = false;
  bool has_velocity_closures_ = false;  ///< there are closures of rates alone
  long evaluations_left_ = max_evaluations;
  double budget_reset_time_ = 0;  ///< when they are counted anew [s]
  double round_off_;
  TreeState<S> state_;
  DriveSample sample_;
  RegularityMonitor<S>* guard_ = nullptr;
  std::vector<ColumnId> matrix_columns_;
  double pivot_threshold_ = singular_pivot_threshold;  ///< smallest pivot that counts as regular
  PivotExtrapolation approach_,
      actuation_extrapolation_;  ///< of the matrix that determines the motion, of the guarded one
  SingularityMonitor<S> singularity_monitor_;
  double way_ = 0;         ///< how far the step last judged turns the mechanism
  double hold_pivot_ = 1;  ///< of the guarded matrix, at its end
  CoordinateSample now_, previous_, second_previous_, next_;
  int history_count_ = 0;             ///< how many of before_, older_ continue smoothly into now_
  double next_step_size_ = INFINITY;  ///< step to be tried next [s]
  int iterations_ = 0, references_ = 0;
  VectorX predicted_, trial_;
  std::vector<double> x_;      ///< right-hand side, then solution
  std::vector<double> rates_;  ///< dy at the configuration of the last Newton step
  MotionOutcome outcome_;
};

extern template class MotionStepper<Planar>;
extern template class MotionStepper<Spatial>;

}  // namespace balance
