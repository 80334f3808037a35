#pragma once
/// From a trajectory as stated to something that can be followed: which equations drive the mechanism, the start
/// configuration, and the prescribed values over time. Private to motion and dynamics.

#include "balance/kinematics/assembly.hpp"
#include "balance/motion/drive_quantities.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/motion/trajectory.hpp"

#include <optional>

namespace balance {

template <class S>
struct Plan {
  MotionOutcome outcome;  ///< done: can be followed
  Drive<S> drive;
  VectorX start;           ///< y at time 0
  int freedoms = 0;        ///< by rank
  bool redundant = false;  ///< closures have more rows than rank
  std::optional<Schedule> schedule;
};

/// @throws std::invalid_argument if the trajectory asks for something that does not exist (a tool that the mechanism lacks)
template <class S>
Plan<S> make_plan(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory);

/// The equations that a pose states, with their values.
template <class S>
struct PoseEquations {
  Drive<S> drive;
  DriveSample target;
};
template <class S>
PoseEquations<S> pose_equations(const Mechanism& mechanism, const Tree<S>& tree, const PoseTarget& pose);

/// Fills in the tool's frame and path.
template <class S>
void attach_tool(const Mechanism& mechanism, const Tree<S>& tree, Drive<S>& drive);

/// A joint coordinate as a quantity linear in y.
template <class S>
LinearQuantity coordinate_row(const Mechanism& mechanism, const Tree<S>& tree, int coordinate);

/// Angle of the tool's body against the world's x axis, continuous over whole turns.
LinearQuantity tool_angle(const Tree<Planar>& tree, const FixedFrame<Planar>& tool);

/// Root-mean-square distance of a configuration from the mechanism's `assembly` values, angles modulo whole turns, lengths in
/// units of the characteristic length.
template <class S>
double distance_from_assembly(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y);

/// The configuration that meets a pose in the assembly mode nearest to the mechanism's `assembly` values.
template <class S>
Solution find_pose(const Mechanism& mechanism, const Tree<S>& tree, System<S>& system, const DriveSample& target);

#define BALANCE_DECLARE(S)                                                                                 \
  extern template Plan<S> make_plan<S>(const Mechanism&, const Tree<S>&, const Trajectory&);               \
  extern template PoseEquations<S> pose_equations<S>(const Mechanism&, const Tree<S>&, const PoseTarget&); \
  extern template void attach_tool<S>(const Mechanism&, const Tree<S>&, Drive<S>&);                        \
  extern template LinearQuantity coordinate_row<S>(const Mechanism&, const Tree<S>&, int);                 \
  extern template double distance_from_assembly<S>(const Mechanism&, const Tree<S>&, const VectorX&);      \
  extern template Solution find_pose<S>(const Mechanism&, const Tree<S>&, System<S>&, const DriveSample&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance
