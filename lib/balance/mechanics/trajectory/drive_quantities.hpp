#pragma once
/// Quantities that a trajectory prescribes, from the spec alone: plain values from which every formulation builds its
/// equations.

#include "balance/mechanics/trajectory/drive_sample.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <string>
#include <vector>

namespace balance::trajectory {

/// Whether all coordinates that the trajectory names are free or held.
bool drives_nothing(const Trajectory& trajectory);

/// What is driven, in the spec language: "joints", "tool", "com" or "none".
const char* drive_name(const Trajectory& trajectory);

/// Number of remaining quantities that the trajectory names, in addition to the tool or the centre of mass.
int count_remaining_quantities(const Trajectory& trajectory);

/// All coordinates that the trajectory prescribes or gives a value for.
std::vector<CoordinateId> prescribed_coordinates(const Trajectory& trajectory);

/// The prescribed scalars in the order of DriveValue::value: point, com, planar tool angle, coordinates. In addition,
/// the components of a spatial tool's rotation.
struct DriveQuantities {
  std::vector<int> point;     ///< world components of the tool point
  std::vector<int> com;       ///< world components of the centre of mass
  bool tool_angle = false;    ///< planar: angle of the tool's body
  std::vector<int> rotation;  ///< spatial: world components of the tool's rotation
  std::vector<CoordinateId> coordinates;
  std::string mismatch;  ///< why their number differs from the degrees of freedom; empty if it does not

  int value_count() const {
    return static_cast<int>(point.size() + com.size() + coordinates.size()) + (tool_angle ? 1 : 0);
  }
  int row_count() const { return value_count() + static_cast<int>(rotation.size()); }
};

/// Chooses as many quantities as there are degrees of freedom: those named by the trajectory, or the defaults of the
/// spec language. Coordinates with a course are the last ones.
/// @throws std::invalid_argument if the trajectory names something that does not exist
DriveQuantities choose_drive_quantities(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms);

/// All quantities that a pose specifies.
/// @throws std::invalid_argument if it names a tool that the mechanism lacks
DriveQuantities list_pose_quantities(const Mechanism& mechanism, const PoseTarget& pose);

/// Prescribed values of a pose; values that it does not specify are taken from `base`.
DriveValue read_pose_values(const DriveQuantities& quantities, const PoseTarget& pose, const DriveValue& base);

/// Whether the pose `to` determines the end of the driven quantities without a search for a configuration. Quantities
/// that it does not specify keep their values.
bool is_end_prescribed(const DriveQuantities& quantities, const Trajectory& trajectory);

/// The request from which the prescribed motion is made.
/// @param from, to values of the drive's quantities at the ends
/// @throws std::invalid_argument if a secondary task is not a quantity of the drive
PrescribedMotion::Request make_prescribed_motion_request(const Trajectory& trajectory,
                                                         const DriveQuantities& quantities, DriveValue from,
                                                         DriveValue to);

}  // namespace balance::trajectory
