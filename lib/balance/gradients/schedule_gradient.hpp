#pragma once
/// Prescribed values with their derivatives by numbers of the trajectory (its poses, way, courses, law, duration) and of the mechanism: a
/// pose that is stated in other quantities than the drive's (the tool stated, the joints driven) is measured where it was found. Private
/// to gradients.

#include "balance/gradients/over_duals.hpp"
#include "balance/motion/plan.hpp"

#include <array>
#include <vector>

namespace balance {

class ScheduleGradient {
 public:
  /// @param values of the trajectory @param plan done, of the values; must outlive this
  template <class S>
  ScheduleGradient(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                   const std::vector<CoordinateId>& needed, const TrajectoryOf<DualNumber>& trajectory,
                   const Trajectory& values, const Plan<S>& plan);

  /// Values, rates and accelerations with their derivatives at a place that stays the same part of the duration, or at a jump, which goes
  /// where the numbers move it. Where they are linear in a number, and by the duration, exact; else differences of fourth order of a smooth
  /// function in closed form, good to some 1e-11.
  /// @param jump which of the schedule's jumps the time is; −1: none
  /// @return the time with its derivatives [s]
  DualNumber at(double time, Side side, long jump, DriveSampleOf<DualNumber>& sample);
  /// Whether that jump's part of the duration depends on a number.
  bool moves(long jump) const;

 private:
  /// The schedule whose values are the derivatives themselves.
  struct Tangent {
    std::size_t number;
    Schedule schedule;
  };
  /// Schedules with the number moved by −2, −1, 1 and 2 steps.
  struct Neighbours {
    std::size_t number;
    double step;
    std::vector<Schedule> schedules;
    bool same_jumps;  ///< as many as without a step
  };
  /// The values at the ends, and what they change by.
  struct Ends {
    DriveValue from, to;
  };
  using Ways = std::array<Trajectory, dual_width>;  ///< per number: derivatives in a trajectory's places

  template <class S>
  std::array<Ends, dual_width> derive_ends(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                                           const std::vector<CoordinateId>& needed,
                                           const TrajectoryOf<DualNumber>& trajectory, const Plan<S>& plan,
                                           const Ways& rates) const;
  void add_tangent(std::size_t number, const Trajectory& values, const Trajectory& rate, const Ends& ends,
                   const DriveQuantities& quantities);
  void add_neighbours(std::size_t number, const TrajectoryOf<DualNumber>& trajectory, double size,
                      const Schedule::Request& request, const Ends& ends, const DriveQuantities& quantities);

  const Schedule& schedule_;
  std::vector<Tangent> tangents_;
  std::vector<Neighbours> neighbours_;
  std::array<double, dual_width> stretch_{};  ///< per number: the duration's derivative as part of the duration
  DriveSample now_;
};

extern template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Planar>&,
                                                   const std::vector<CoordinateId>&, const TrajectoryOf<DualNumber>&,
                                                   const Trajectory&, const Plan<Planar>&);
extern template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Spatial>&,
                                                   const std::vector<CoordinateId>&, const TrajectoryOf<DualNumber>&,
                                                   const Trajectory&, const Plan<Spatial>&);

}  // namespace balance
