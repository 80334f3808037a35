#pragma once
/// Prescribed values with their derivatives with respect to variables of the trajectory (poses, path, secondary tasks,
/// law, duration) and of the mechanism: if a pose is stated in quantities other than the driven ones (the tool stated,
/// the joints driven), these are measured at the configuration found for it.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include <array>
#include <vector>

namespace balance::derivatives {

class PrescribedMotionGradient {
 public:
  /// @param values the trajectory's values @param plan compiled from the values, with outcome done; must outlive this
  template <class S>
  PrescribedMotionGradient(const MechanismOf<DualNumber>& mechanism, const kinematics::Tree<S>& tree,
                           const std::vector<CoordinateId>& needed, const TrajectoryOf<DualNumber>& trajectory,
                           const Trajectory& values, const kinematics::CompiledTrajectory<S>& plan);

  /// Values, rates and accelerations with their derivatives, taken at a constant fraction of the duration, or at a
  /// jump, which moves with the variables. Derivatives with respect to the duration, and to variables in which the
  /// values are linear, are exact. All others are fourth-order differences of a smooth closed-form function, accurate
  /// to about 1e-11.
  /// @param jump index of the jump at this time; −1: none
  /// @return the time with its derivatives [s]
  DualNumber at(double time, trajectory::Side side, long jump, trajectory::DriveSampleOf<DualNumber>& sample);
  /// Whether the jump, as a fraction of the duration, depends on any variable.
  bool is_moving_jump(long jump) const;

 private:
  /// A prescribed motion whose values are the derivatives themselves.
  struct TangentMotion {
    std::size_t variable;
    trajectory::PrescribedMotion motion;
  };
  /// Prescribed motions with the variable shifted by −2, −1, 1 and 2 steps.
  struct DifferenceStencil {
    std::size_t variable;
    double step;
    std::vector<trajectory::PrescribedMotion> motions;
    bool has_matching_jumps;  ///< all have as many jumps as the unshifted motion
  };
  /// Derivatives of the prescribed values at both ends.
  struct Endpoints {
    trajectory::DriveValue from, to;
  };
  using TrajectoryDerivatives =
      std::array<Trajectory,
                 numerics::dual_width>;  ///< per variable: derivatives, stored in place of the trajectory's values

  template <class S>
  std::array<Endpoints, numerics::dual_width> differentiate_endpoints(const MechanismOf<DualNumber>& mechanism,
                                                                      const kinematics::Tree<S>& tree,
                                                                      const std::vector<CoordinateId>& needed,
                                                                      const TrajectoryOf<DualNumber>& trajectory,
                                                                      const kinematics::CompiledTrajectory<S>& plan,
                                                                      const TrajectoryDerivatives& rates) const;
  void add_tangent(std::size_t variable, const Trajectory& values, const Trajectory& rate, const Endpoints& ends,
                   const trajectory::DriveQuantities& quantities);
  void add_stencil(std::size_t variable, const TrajectoryOf<DualNumber>& trajectory, double size,
                   const trajectory::PrescribedMotion::Request& request, const Endpoints& ends,
                   const trajectory::DriveQuantities& quantities);

  const trajectory::PrescribedMotion& prescribed_motion_;
  std::vector<TangentMotion> tangents_;
  std::vector<DifferenceStencil> stencils_;
  std::array<double, numerics::dual_width>
      relative_duration_rate_{};  ///< per variable: derivative of the duration divided by the duration
  trajectory::DriveSample drive_sample_;
};

extern template PrescribedMotionGradient::PrescribedMotionGradient(
    const MechanismOf<DualNumber>&, const kinematics::Tree<kinematics::Planar>&, const std::vector<CoordinateId>&,
    const TrajectoryOf<DualNumber>&, const Trajectory&, const kinematics::CompiledTrajectory<kinematics::Planar>&);
extern template PrescribedMotionGradient::PrescribedMotionGradient(
    const MechanismOf<DualNumber>&, const kinematics::Tree<kinematics::Spatial>&, const std::vector<CoordinateId>&,
    const TrajectoryOf<DualNumber>&, const Trajectory&, const kinematics::CompiledTrajectory<kinematics::Spatial>&);

}  // namespace balance::derivatives
