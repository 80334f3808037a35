#pragma once
/// Compiles a trajectory into a form that can be followed: the equations that drive the mechanism, the start
/// configuration, and the prescribed values over time.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>

namespace balance::kinematics {

template <class S>
struct CompiledTrajectory {
  MotionOutcome outcome;  ///< done: can be followed
  Drive<S> drive;
  trajectory::DriveQuantities quantities;  ///< that the drive prescribes
  VectorX start;                           ///< y at time 0
  VectorX end;       ///< y at the end pose, if the drive's values had to be measured there; else empty
  int freedoms = 0;  ///< computed by rank
  bool has_redundant_closures = false;  ///< closures have more rows than rank
  std::optional<trajectory::PrescribedMotion> prescribed_motion;
  trajectory::PrescribedMotion::Request request;  ///< from which prescribed_motion was made
};

/// @throws std::invalid_argument if the trajectory asks for something that does not exist (a tool that the mechanism
///        lacks)
template <class S>
CompiledTrajectory<S> compile_trajectory(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory);

/// The tree of a mechanism, and a trajectory compiled for it.
template <class S>
struct CompiledMotion {
  /// @throws std::invalid_argument as compile_trajectory
  CompiledMotion(const Mechanism& mechanism, const Trajectory& trajectory)
      : tree(compile_tree<S>(mechanism, prescribed_coordinates(trajectory))),
        plan(compile_trajectory(mechanism, tree, trajectory)) {}

  Tree<S> tree;
  CompiledTrajectory<S> plan;
};

/// The equations that a pose states, with their values.
template <class S>
struct PoseEquations {
  Drive<S> drive;
  trajectory::DriveSampleOf<typename S::Scalar> target;
};
template <class S>
PoseEquations<S> make_pose_equations(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                                     const trajectory::PoseTargetOf<typename S::Scalar>& pose);

/// The equations of the driven quantities.
template <class S>
Drive<S> make_drive(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                    const trajectory::DriveQuantities& quantities);

/// Fills in the tool's frame and path.
template <class S>
void set_tool_frame(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree, Drive<S>& drive);

/// A joint coordinate as a quantity linear in y.
template <class S>
LinearQuantityOf<typename S::Scalar> find_coordinate_expression(const MechanismOf<typename S::Scalar>& mechanism,
                                                                const Tree<S>& tree, CoordinateId coordinate);

/// Angle of the tool's body relative to the world's x axis, continuous over full turns.
template <class T>
LinearQuantityOf<T> make_tool_angle_expression(const Tree<PlanarOf<T>>& tree, const FixedFrame<PlanarOf<T>>& tool);

/// Root-mean-square distance of a configuration from the mechanism's `assembly` values, angles modulo full turns,
/// lengths in units of the characteristic length.
template <class S>
double distance_from_assembly(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y);

/// The configuration that meets a pose in the assembly mode nearest to the mechanism's `assembly` values.
template <class S>
AssemblySolution solve_pose(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                            const trajectory::DriveSample& target);

#define BALANCE_DECLARE(S)                                                                                          \
  extern template CompiledTrajectory<S> compile_trajectory<S>(const Mechanism&, const Tree<S>&, const Trajectory&); \
  extern template double distance_from_assembly<S>(const Mechanism&, const Tree<S>&, const VectorX&);               \
  extern template AssemblySolution solve_pose<S>(const Mechanism&, const Tree<S>&, ConstraintSystem<S>&,            \
                                                 const trajectory::DriveSample&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance::kinematics
