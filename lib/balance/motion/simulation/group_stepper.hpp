#pragma once
/// Follows a compiled trajectory and evaluates everything along it, like a MotionStepper with a SampleEvaluator, but
/// many moments at once wherever possible.

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/lanes/lane_kernels.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <array>
#include <memory>

namespace balance {

/// Between two jumps of the acceleration the stepper makes one group of even steps, and further groups are predicted
/// from those before. If any moment of a group is doubtful (no convergence, too long a step, near a singularity), the
/// group is left to the stepper: only the stepper decides on failures and notes of a run.
template <class S>
class GroupStepper {
 public:
  /// All references must outlive it.
  /// @param stepper monitors the observer's regularity
  /// @param about reference point of moments in the world
  /// @param instruction_set for groups: results do not depend on it, see docs/developing.md
  GroupStepper(const Mechanism& mechanism, const Tree<S>& tree, const CompiledTrajectory<S>& plan,
               const TimeGrid& times, const typename S::Vector& about, MotionStepper<S>& stepper,
               SampleEvaluator<S>& observer, InstructionSet instruction_set = list_instruction_sets().back());

  // For visit_time_grid().
  bool begin();
  bool advance(double time);
  void update_accelerations(Side side);
  double time() const { return stepper_.time(); }

  /// Call when the tree's masses have changed at the current moment.
  void update_masses();
  /// Evaluates everything at the current moment.
  /// @return false if the actuators do not hold the mechanism there
  bool observe();
  const Sample& last() const { return *sample_; }
  /// Number of moments computed in groups so far.
  long group_step_count() const { return group_step_count_; }
  /// The current moment for further evaluation, with the observer evaluated there.
  TreeMotion<S> at_current_sample();

 private:
  void synchronise_stepper();
  void record_step();
  void restart();
  bool try_group();
  bool solve_group();
  bool sample_drive(double before);
  bool is_accepted() const;
  void adopt_next();

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  const CompiledTrajectory<S>& plan_;
  TimeGrid times_;
  typename S::Vector about_;
  MotionStepper<S>& stepper_;
  SampleEvaluator<S>& observer_;
  InstructionSet instruction_set_;
  bool is_explicit_, can_use_groups_;
  long step_ = 0;                           ///< index of the next even step
  bool is_at_even_step_ = false;            ///< the current moment is at the end of an even step
  std::array<GroupCoordinates, 4> groups_;  ///< the one that the stepper is making, then previous ones, latest first
  int history_count_ = 0, recorded_count_ = 0;  ///< number of previous groups; number of moments in the first
  int backoff_ = 0, remaining_skips_ = 0;       ///< groups to skip after the last failure, and the number left
  std::unique_ptr<GroupSolver<S>> group_solver_;
  long group_step_count_ = 0;
  bool is_solver_started_ = false;  ///< group_solver_ is at the end of the last group
  bool is_stepper_behind_ = false;  ///< the stepper's matrices are not those of the current moment
  GroupJob job_;
  std::array<double, group_size> group_times_{};  ///< times of the group
  int next_in_group_ = group_size;                ///< next moment of the computed group
  bool in_group_ = false;                         ///< the current moment belongs to a computed group
  DriveSample drive_;
  CoordinateSample coordinate_sample_;
  Sample* sample_ = nullptr;
};

extern template class GroupStepper<Planar>;
extern template class GroupStepper<Spatial>;

}  // namespace balance
