#pragma once
/// Follows prescribed values through time: Taylor's prediction, Newton on all equations, then velocities and accelerations.
/// Private to natural.

#include "balance/base/tall_matrix.hpp"
#include "balance/motion/approach.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/natural/equations.hpp"

#include <functional>
#include <utility>

namespace balance::natural {

class NaturalStepper {
 public:
  /// @param model, schedule must outlive the stepper
  NaturalStepper(const NaturalModel& model, DriveRows drive, const PrescribedMotion& schedule, int freedoms);

  /// Another matrix that must keep full column rank, from begin() on.
  void set_actuation_matrix(std::function<MatrixX(const NaturalCoordinates&)> held) {
    actuation_matrix_ = std::move(held);
  }
  /// Time 0, from a configuration near it. Also true of advance: on false outcome() says why, and the last good state stays.
  bool begin(const NaturalCoordinates& near);
  /// On to a later time, in as many steps as it takes to stay on the same assembly mode.
  bool advance(double time);
  /// Accelerations on one side of the present time (advance() leaves those of the side `after`).
  void accelerate(Side side);

  double time() const { return now_.time; }
  double duration() const { return schedule_.duration(); }  ///< of the whole motion [s]
  const NaturalState& state() const { return now_; }
  /// Angle of every body, running on past ±π [rad], with its rates; from the scalars or read off the directions.
  const std::vector<double>& angles() const { return angles_; }
  double angular_velocity(BodyId body) const;
  double angular_acceleration(BodyId body) const;
  int iterations() const { return iterations_; }
  const NaturalKinematicEquations& equations() const { return equations_; }
  const MotionOutcome& outcome() const { return outcome_; }

 private:
  enum class StepResult { done, no_convergence, far_from_prediction, natural_pivot_threshold, actuation_singular };

  StepResult step(double time);
  StepResult check_step(const NaturalState& next);
  double curvature(const NaturalState& next) const;
  bool is_far_from_prediction(const NaturalCoordinates& predicted, const NaturalCoordinates& found) const;
  void read_angles(const std::vector<double>& expected);
  void stop(StepResult attempt);

  const NaturalModel& model_;
  const PrescribedMotion& schedule_;
  int freedoms_;
  NaturalKinematicEquations equations_;
  NaturalState now_;
  std::vector<double> angles_;
  DriveSample sample_;
  int iterations_ = 0;
  RankMonitor constraint_monitor_, actuation_;
  PivotExtrapolation approach_, actuation_approach_;
  std::function<MatrixX(const NaturalCoordinates&)> actuation_matrix_;
  MotionOutcome outcome_;
};

}  // namespace balance::natural
