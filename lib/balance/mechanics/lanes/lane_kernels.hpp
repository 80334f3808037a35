#pragma once
/// Computations on many samples at once: a table of functions per instruction set, compiled from one source
/// (cmake/Lanes.cmake).

#include "balance/foundation/base/instruction_set.hpp"
#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <array>
#include <memory>
#include <vector>

namespace balance::lanes {

/// States and torques as tables: one row per state, contiguous in memory, one column per tree coordinate.
struct InverseDynamicsJob {
  long count = 0;
  const double *y = nullptr, *dy = nullptr, *ddy = nullptr;
  double* tau = nullptr;  ///< generalised forces [N m or N]
};

/// Number of instants of a motion that are solved together, whatever the instruction set.
inline constexpr int group_size = 8;

/// Tree coordinates, rates and accelerations at the instants of a group: [column][instant].
struct GroupCoordinates {
  std::vector<double> y, dy, ddy;

  explicit GroupCoordinates(int columns = 0) : y(static_cast<std::size_t>(columns) * group_size), dy(y), ddy(y) {}
};

/// Evenly spaced instants, to be solved from those of the previous groups.
struct GroupJob {
  using PerMoment = std::array<double, group_size>;

  // input
  double step = 0;                                   ///< from instant to instant [s]
  int history_count = 0;                             ///< number of previous groups, at most three
  std::array<const GroupCoordinates*, 3> history{};  ///< the latest first
  /// As DriveSample: [component][instant], the rotation's entries column by column.
  std::vector<double> value, rate, acceleration, rotation, angular_velocity, angular_acceleration;

  // output
  GroupCoordinates coordinates;
  PerMoment pivot{}, hold_pivot{}, distance{}, iterations{};  ///< as StepReport
  std::array<Sample, group_size>
      samples;  ///< without what SampleEvaluator::complete_sample adds; vectors must be sized
};

/// Input of a GroupSolver. All references must outlive it.
template <class S>
struct GroupSetup {
  const Mechanism& mechanism;
  const kinematics::Tree<S>& tree;
  const kinematics::Drive<S>& drive;
  const dynamics::Actuation<S>& actuation;  ///< regular, factorised before
  typename S::Vector about;
  double residual_tolerance;                                ///< scaled residual that cannot be improved upon
  const std::vector<kinematics::ColumnId>& matrix_columns;  ///< columns on which the equations' matrix depends
  bool direct;                                              ///< every column is prescribed on its own
};

/// Solves a motion without external forces and friction and with independent closures: poses by Newton's method, rates,
/// accelerations, and everything that a SampleEvaluator computes. Each instant is solved on its own: the results do not
/// depend on its neighbours or their number.
template <class S>
class GroupSolver {
 public:
  virtual ~GroupSolver() = default;

  /// The next group follows an instant with these matrices, coordinates and rates.
  virtual void start(const kinematics::KinematicEquations<S>& equations, const dynamics::Actuation<S>& actuation,
                     const double* y, const double* dy) = 0;
  /// Solves the next group.
  /// @return false if any of its instants is not found, is far from its prediction, or is not near the previous one;
  ///        the next call must then be start()
  virtual bool solve(GroupJob& job) = 0;
};

struct LaneKernels {
  // As open_tree_inverse_dynamics (mechanics/dynamics/tree_dynamics.hpp), for every state.
  void (*planar_torques)(const kinematics::Tree<kinematics::Planar>& tree, const Vector2& gravity,
                         const InverseDynamicsJob& job);
  void (*spatial_torques)(const kinematics::Tree<kinematics::Spatial>& tree, const Vector3& gravity,
                          const InverseDynamicsJob& job);
  std::unique_ptr<GroupSolver<kinematics::Planar>> (*planar_motion)(const GroupSetup<kinematics::Planar>& setup);
  std::unique_ptr<GroupSolver<kinematics::Spatial>> (*spatial_motion)(const GroupSetup<kinematics::Spatial>& setup);
};

/// @param set one of list_instruction_sets(), of which the last is the fastest
/// @throws std::invalid_argument if this machine or this library lacks it
const LaneKernels& lane_kernels(InstructionSet set);

}  // namespace balance::lanes
