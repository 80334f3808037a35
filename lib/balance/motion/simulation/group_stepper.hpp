#pragma once
/// Follows a motion and evaluates everything along it, like a TreeMotionSource, but many moments at once wherever
/// possible.

#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/lanes/lane_kernels.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <array>
#include <memory>

namespace balance::simulation {

/// Between two jumps of the acceleration the stepper makes one group of even steps, and further groups are predicted
/// from those before. If any moment of a group is doubtful (no convergence, too long a step, near a singularity), the
/// group is left to the stepper: only the stepper decides on failures and notes of a run.
template <class S>
class GroupStepper final : public trajectory::MotionSource {
 public:
  /// @param source evaluates Detail::all; must outlive this object
  /// @param samples of the time grid that is to be visited
  /// @param instruction_set for groups: results do not depend on it, see docs/developing.md
  GroupStepper(dynamics::TreeMotionSource<S>& source, long samples,
               InstructionSet instruction_set = list_instruction_sets().back());

  const MotionOutcome& outcome() const override { return source_.outcome(); }
  const trajectory::PrescribedMotion& prescribed_motion() const override { return source_.prescribed_motion(); }
  bool begin() override;
  bool advance(double time) override;
  void update_accelerations(trajectory::Side side) override;
  bool update_payloads() override;
  double time() const override { return stepper_.time(); }
  bool evaluate() override;
  const Sample& sample() const override { return *sample_; }
  double point_speed(BodyId body, const Vector3& point) const override { return source_.point_speed(body, point); }
  double angular_speed(BodyId body) const override { return source_.angular_speed(body); }

  /// Number of moments computed in groups so far.
  long group_step_count() const { return group_step_count_; }
  /// The current moment for further evaluation, with the observer evaluated there.
  dynamics::TreeMotion<S> at_current_sample();

 private:
  void synchronise_stepper();
  void record_step();
  void restart();
  bool try_group();
  bool solve_group();
  bool sample_drive(double before);
  bool is_accepted() const;
  void adopt_next();

  dynamics::TreeMotionSource<S>& source_;
  const kinematics::Tree<S>& tree_;
  const kinematics::CompiledTrajectory<S>& plan_;
  kinematics::MotionStepper<S>& stepper_;
  dynamics::SampleEvaluator<S>& observer_;
  trajectory::TimeGrid times_;
  InstructionSet instruction_set_;
  bool is_explicit_, can_use_groups_;
  long step_ = 0;                 ///< index of the next even step
  bool is_at_even_step_ = false;  ///< the current moment is at the end of an even step
  std::array<lanes::GroupCoordinates, 4>
      groups_;  ///< the one that the stepper is making, then previous ones, latest first
  int history_count_ = 0, recorded_count_ = 0;  ///< number of previous groups; number of moments in the first
  int backoff_ = 0, remaining_skips_ = 0;       ///< groups to skip after the last failure, and the number left
  std::unique_ptr<lanes::GroupSolver<S>> group_solver_;
  long group_step_count_ = 0;
  bool is_solver_started_ = false;  ///< group_solver_ is at the end of the last group
  bool is_stepper_behind_ = false;  ///< the stepper's matrices are not those of the current moment
  lanes::GroupJob job_;
  std::array<double, lanes::group_size> group_times_{};  ///< times of the group
  int next_in_group_ = lanes::group_size;                ///< next moment of the computed group
  bool in_group_ = false;                                ///< the current moment belongs to a computed group
  trajectory::DriveSample drive_;
  kinematics::CoordinateSample coordinate_sample_;
  const Sample* sample_;
};

extern template class GroupStepper<kinematics::Planar>;
extern template class GroupStepper<kinematics::Spatial>;

}  // namespace balance::simulation
