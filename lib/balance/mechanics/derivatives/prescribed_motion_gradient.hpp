#pragma once
/// Prescribed values with their derivatives by numbers of the trajectory (its poses, way, courses, law, duration) and of the mechanism: a
/// pose that is stated in other quantities than the drive's (the tool stated, the joints driven) is measured where it was found.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include <array>
#include <vector>

namespace balance {

class PrescribedMotionGradient {
 public:
  /// @param values of the trajectory @param plan done, of the values; must outlive this
  template <class S>
  PrescribedMotionGradient(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                           const std::vector<CoordinateId>& needed, const TrajectoryOf<DualNumber>& trajectory,
                           const Trajectory& values, const CompiledTrajectory<S>& plan);

  /// Values, rates and accelerations with their derivatives at a place that stays the same part of the duration, or at a jump, which goes
  /// where the numbers move it. Where they are linear in a number, and by the duration, exact; else differences of fourth order of a smooth
  /// function in closed form, good to some 1e-11.
  /// @param jump which of the schedule's jumps the time is; −1: none
  /// @return the time with its derivatives [s]
  DualNumber at(double time, Side side, long jump, DriveSampleOf<DualNumber>& sample);
  /// Whether that jump's part of the duration depends on a number.
  bool is_moving_jump(long jump) const;

 private:
  /// The schedule whose values are the derivatives themselves.
  struct TangentMotion {
    std::size_t number;
    PrescribedMotion schedule;
  };
  /// Schedules with the number moved by −2, −1, 1 and 2 steps.
  struct DifferenceStencil {
    std::size_t number;
    double step;
    std::vector<PrescribedMotion> schedules;
    bool has_matching_jumps;  ///< as many as without a step
  };
  /// The values at the ends, and what they change by.
  struct Endpoints {
    DriveValue from, to;
  };
  using TrajectoryDerivatives =
      std::array<Trajectory, dual_width>;  ///< per number: derivatives in a trajectory's places

  template <class S>
  std::array<Endpoints, dual_width> differentiate_endpoints(const MechanismOf<DualNumber>& mechanism,
                                                            const Tree<S>& tree,
                                                            const std::vector<CoordinateId>& needed,
                                                            const TrajectoryOf<DualNumber>& trajectory,
                                                            const CompiledTrajectory<S>& plan,
                                                            const TrajectoryDerivatives& rates) const;
  void add_tangent(std::size_t number, const Trajectory& values, const Trajectory& rate, const Endpoints& ends,
                   const DriveQuantities& quantities);
  void add_stencil(std::size_t number, const TrajectoryOf<DualNumber>& trajectory, double size,
                   const PrescribedMotion::Request& request, const Endpoints& ends, const DriveQuantities& quantities);

  const PrescribedMotion& schedule_;
  std::vector<TangentMotion> tangents_;
  std::vector<DifferenceStencil> neighbours_;
  std::array<double, dual_width>
      relative_duration_rate_{};  ///< per number: the duration's derivative as part of the duration
  DriveSample now_;
};

extern template PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>&, const Tree<Planar>&,
                                                                   const std::vector<CoordinateId>&,
                                                                   const TrajectoryOf<DualNumber>&, const Trajectory&,
                                                                   const CompiledTrajectory<Planar>&);
extern template PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>&, const Tree<Spatial>&,
                                                                   const std::vector<CoordinateId>&,
                                                                   const TrajectoryOf<DualNumber>&, const Trajectory&,
                                                                   const CompiledTrajectory<Spatial>&);

}  // namespace balance
