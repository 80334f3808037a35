#pragma once
/// What a trajectory prescribes, read off the spec alone: plain values that every formulation turns into equations of its own.

#include "balance/mechanics/trajectory/drive_sample.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <string>
#include <vector>

namespace balance {

/// How many quantities go beside the tool or the centre of mass by the trajectory's own word.
int count_remaining_quantities(const Trajectory& trajectory);

/// Coordinates that the trajectory prescribes or states anywhere.
std::vector<CoordinateId> prescribed_coordinates(const Trajectory& trajectory);

/// The prescribed scalars in the order of DriveValue::value: point, com, the planar tool's angle, coordinates; and the
/// components of a spatial tool's rotation.
struct DriveQuantities {
  std::vector<int> point;     ///< world components of the tool point
  std::vector<int> com;       ///< world components of the centre of mass
  bool tool_angle = false;    ///< planar: angle of the tool's body
  std::vector<int> rotation;  ///< spatial: world components of the tool's rotation
  std::vector<CoordinateId> coordinates;
  std::string mismatch;  ///< why they do not fit the freedoms; empty if they do

  int value_count() const {
    return static_cast<int>(point.size() + com.size() + coordinates.size()) + (tool_angle ? 1 : 0);
  }
  int row_count() const { return value_count() + static_cast<int>(rotation.size()); }
};

/// As many quantities as the mechanism has freedoms: those that the trajectory names, or the defaults of the spec language.
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
DriveQuantities choose_drive_quantities(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms);

/// The quantities that a pose states, all of them.
/// @throws std::invalid_argument if it names a tool that the mechanism lacks
DriveQuantities list_pose_quantities(const Mechanism& mechanism, const PoseTarget& pose);

/// Prescribed values that a pose states; whatever it leaves out is taken from `base`.
DriveValue read_pose_values(const DriveQuantities& quantities, const PoseTarget& pose, const DriveValue& base);

/// The pose `to` says enough of the driven quantities that no configuration has to be found for it: what it leaves out stays.
bool is_end_prescribed(const DriveQuantities& quantities, const Trajectory& trajectory);

}  // namespace balance
