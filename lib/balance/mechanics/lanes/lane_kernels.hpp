#pragma once
/// What is computed for many samples at once: a table of functions for every instruction set, compiled from one source
/// (cmake/Lanes.cmake).

#include "balance/foundation/base/instruction_set.hpp"
#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <array>
#include <memory>
#include <vector>

namespace balance {

/// States and torques as tables: one row per state, contiguous in memory, as wide as the tree has coordinates.
struct InverseDynamicsJob {
  long count = 0;
  const double *y = nullptr, *dy = nullptr, *ddy = nullptr;
  double* tau = nullptr;  ///< generalised forces [N m or N]
};

/// So many moments of a motion are found together, whatever the instruction set.
inline constexpr int group_size = 8;

/// Of tree coordinates at the moments of a group: [column][moment].
struct GroupCoordinates {
  std::vector<double> y, dy, ddy;

  explicit GroupCoordinates(int columns = 0) : y(static_cast<std::size_t>(columns) * group_size), dy(y), ddy(y) {}
};

/// Evenly spaced moments, to be found from those of the groups before.
struct GroupJob {
  using PerMoment = std::array<double, group_size>;

  // given
  double step = 0;                                   ///< from moment to moment [s]
  int history_count = 0;                             ///< groups before, at most three
  std::array<const GroupCoordinates*, 3> history{};  ///< the latest first
  /// As DriveSample: [component][moment], the rotation's entries column by column.
  std::vector<double> value, rate, acceleration, rotation, angular_velocity, angular_acceleration;

  // found
  GroupCoordinates coordinates;
  PerMoment pivot{}, hold_pivot{}, distance{}, iterations{};  ///< as StepReport
  std::array<Sample, group_size>
      samples;  ///< less what SampleEvaluator::complete_sample adds; vectors must have their sizes
};

/// What a motion is found from. Everything must outlive the motion.
template <class S>
struct GroupSetup {
  const Mechanism& mechanism;
  const Tree<S>& tree;
  const Drive<S>& drive;
  const Actuation<S>& actuation;  ///< regular, used before
  typename S::Vector about;
  double residual_tolerance;                    ///< scaled residual that cannot be improved upon
  const std::vector<ColumnId>& matrix_columns;  ///< columns on which the equations' matrix depends
  bool direct;                                  ///< every column is prescribed by itself
};

/// A motion without external forces and friction, with independent closures: Newton's method on the poses, rates, accelerations and
/// all that a SampleEvaluator finds. Each moment by itself: what is found of one does not depend on its neighbours or on how many
/// there are.
template <class S>
class GroupSolver {
 public:
  virtual ~GroupSolver() = default;

  /// The next group follows upon a moment with these matrices, coordinates and rates.
  virtual void start(const KinematicEquations<S>& equations, const Actuation<S>& actuation, const double* y,
                     const double* dy) = 0;
  /// The next group.
  /// @return false if any of its moments is not found, is far from what was predicted, or not near the one before it; then the next
  ///         call must be start()
  virtual bool solve(GroupJob& job) = 0;
};

struct LaneKernels {
  // As open_tree_inverse_dynamics (mechanics/dynamics/tree_dynamics.hpp), state by state.
  void (*planar_torques)(const Tree<Planar>& tree, const Vector2& gravity, const InverseDynamicsJob& job);
  void (*spatial_torques)(const Tree<Spatial>& tree, const Vector3& gravity, const InverseDynamicsJob& job);
  std::unique_ptr<GroupSolver<Planar>> (*planar_motion)(const GroupSetup<Planar>& setup);
  std::unique_ptr<GroupSolver<Spatial>> (*spatial_motion)(const GroupSetup<Spatial>& setup);
};

/// @param set one of list_instruction_sets(), of which the last is the quickest
/// @throws std::invalid_argument if this machine or this library lacks it
const LaneKernels& lane_kernels(InstructionSet set);

}  // namespace balance
