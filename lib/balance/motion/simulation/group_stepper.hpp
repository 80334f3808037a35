#pragma once
/// Follows a plan and finds everything along it like a MotionStepper with a SampleEvaluator, but many moments at once wherever that can be
/// done.

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/lanes/lane_kernels.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <array>
#include <memory>

namespace balance {

/// Between two jumps of the acceleration the stepper makes a group of even steps, and groups found from those before follow. A group
/// of which any moment raises a doubt (no convergence, too long a step, the neighbourhood of a singularity) is left to the stepper:
/// what a run refuses and tells is the stepper's alone.
template <class S>
class GroupStepper {
 public:
  /// All must outlive it. @param stepper watches the observer's guard  @param about world point that moments are about
  /// @param set that groups are found with: no matter which, see docs/developing.md
  GroupStepper(const Mechanism& mechanism, const Tree<S>& tree, const CompiledTrajectory<S>& plan,
               const TimeGrid& times, const typename S::Vector& about, MotionStepper<S>& stepper,
               SampleEvaluator<S>& observer, InstructionSet set = list_instruction_sets().back());

  // For visit_time_grid().
  bool begin();
  bool advance(double time);
  void update_accelerations(Side side);
  double time() const { return stepper_.time(); }

  /// The tree's masses are others from the present moment on.
  void update_masses();
  /// Finds everything at the present moment.
  /// @return false if the actuators do not hold the mechanism there
  bool observe();
  const Sample& last() const { return *seen_; }
  /// How many moments were found in groups so far.
  long group_step_count() const { return found_; }
  /// The present moment for a closer look, with the observer's findings there.
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
  InstructionSet set_;
  bool direct_, can_use_groups_;
  long step_ = 0;                           ///< the next of the even steps
  bool on_time_ = false;                    ///< the present moment is at the end of one
  std::array<GroupCoordinates, 4> groups_;  ///< the one that the stepper is making, and those before, the latest first
  int history_count_ = 0, recorded_ = 0;    ///< groups before; moments of the first
  int backoff_ = 0, skipped_ = 0;           ///< groups that are not tried: after the last failure, of these left
  std::unique_ptr<GroupSolver<S>> motion_;
  long found_ = 0;
  bool started_ = false;            ///< motion_ is where the last group ended
  bool is_stepper_behind_ = false;  ///< the stepper's matrices are not those of the present moment
  GroupJob job_;
  std::array<double, group_size> ends_{};  ///< the group's times
  int next_in_group_ = group_size;         ///< the next moment of the group found
  bool in_group_ = false;                  ///< the present moment is of a group found
  DriveSample drive_;
  CoordinateSample moment_;
  Sample* seen_ = nullptr;
};

extern template class GroupStepper<Planar>;
extern template class GroupStepper<Spatial>;

}  // namespace balance
