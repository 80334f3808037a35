#pragma once
/// Prescribed values whose ends depend on numbers of the mechanism: a pose that is stated in other quantities than the drive's (the tool
/// stated, the joints driven) is measured where it was found. Private to gradients.

#include "balance/gradients/over_duals.hpp"
#include "balance/motion/plan.hpp"

#include <vector>

namespace balance {

class ScheduleGradient {
 public:
  /// @param plan done, of the mechanism's values along the trajectory; must outlive this
  template <class S>
  ScheduleGradient(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree, const std::vector<int>& needed,
                   const Trajectory& trajectory, const Plan<S>& plan);

  /// Values, rates and accelerations with their derivatives. What depends on the ends is a smooth function of them in closed form; its
  /// derivatives are differences of fourth order over a ten-thousandth of the ends' own, good to some 1e-11.
  void at(double time, Side side, DriveSampleOf<DualNumber>& sample) const;

 private:
  /// Schedules with the ends moved by −2, −1, 1 and 2 steps of one number.
  struct Neighbours {
    std::size_t number;
    double step;
    std::vector<Schedule> schedules;
  };

  template <class S>
  void add_neighbours(const Plan<S>& plan, const Trajectory& trajectory, const DriveSampleOf<DualNumber>& from,
                      const DriveSampleOf<DualNumber>& to, std::size_t number);

  const Schedule& schedule_;
  std::vector<Neighbours> neighbours_;
};

extern template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Planar>&,
                                                   const std::vector<int>&, const Trajectory&, const Plan<Planar>&);
extern template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Spatial>&,
                                                   const std::vector<int>&, const Trajectory&, const Plan<Spatial>&);

}  // namespace balance
