#include "balance/mechanics/trajectory/drive_quantities.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include "balance/foundation/base/spelling.hpp"

namespace balance {

int count_remaining_quantities(const Trajectory& trajectory) {
  return static_cast<int>(trajectory.remaining_coordinates.size()) + (trajectory.remaining_angle ? 1 : 0);
}

std::vector<CoordinateId> prescribed_coordinates(const Trajectory& trajectory) {
  std::vector<CoordinateId> coordinates = trajectory.remaining_coordinates;
  const auto add = [&](const PoseTarget& pose) {
    for (const CoordinateValue& joint : pose.joints) coordinates.push_back(joint.coordinate);
  };
  add(trajectory.from);
  add(trajectory.to);
  if (const auto* way = std::get_if<WaypointPath>(&trajectory.path))
    for (const PoseTarget& point : way->points) add(point);
  return coordinates;
}

namespace {

int dimension(const Mechanism& mechanism) { return mechanism.space == SpaceKind::planar ? 2 : 3; }

/// Position components by how much they change from the start to the end, largest first (stable).
std::vector<int> order_by_displacement(const Trajectory& trajectory, int dimension) {
  std::vector<int> order(dimension);
  std::iota(order.begin(), order.end(), 0);
  if (trajectory.from.tool && trajectory.to.tool) {
    const Vector3 way = (*trajectory.to.tool - *trajectory.from.tool).cwiseAbs();
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return way[a] > way[b]; });
  }
  return order;
}

/// The tool's components that as many freedoms can follow, positions first.
std::vector<Component> default_components(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms) {
  using enum Component;
  const bool planar = mechanism.space == SpaceKind::planar;
  const std::vector<Component> all =
      planar ? std::vector<Component>{x, y, rz} : std::vector<Component>{x, y, z, rx, ry, rz};
  if (freedoms == 4 && !planar) return {x, y, z, rz};
  if (freedoms >= dimension(mechanism))
    return std::vector<Component>(
        all.begin(), all.begin() + std::min<std::ptrdiff_t>(freedoms, static_cast<std::ptrdiff_t>(all.size())));
  if (!trajectory.from.tool && trajectory.from.angle && freedoms == 1) return {rz};
  std::vector<int> moving = order_by_displacement(trajectory, dimension(mechanism));
  moving.resize(freedoms);
  std::sort(moving.begin(), moving.end());
  std::vector<Component> chosen;
  for (const int k : moving) chosen.push_back(all[k]);
  return chosen;
}

void add_components(const std::vector<Component>& components, const Mechanism& mechanism, std::vector<int>& place,
                    DriveQuantities& chosen) {
  const bool planar = mechanism.space == SpaceKind::planar;
  for (const Component component : components) {
    const int k = static_cast<int>(component);
    if (k < 3) {
      if (k >= dimension(mechanism)) throw std::invalid_argument("a planar mechanism has no component z");
      place.push_back(k);
    } else if (planar) {
      if (component != Component::rz) throw std::invalid_argument("a planar tool turns about z only");
      chosen.tool_angle = true;
    } else {
      chosen.rotation.push_back(k - 3);
    }
  }
}

std::vector<CoordinateId> named_joints(const Trajectory& trajectory) {
  std::vector<CoordinateId> coordinates;
  for (const CoordinateValue& value : trajectory.from.joints) coordinates.push_back(value.coordinate);
  return coordinates;
}

/// Drive `joints`: what `from` names, or the actuators.
std::vector<CoordinateId> driven_joints(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms) {
  std::vector<CoordinateId> coordinates = named_joints(trajectory);
  const std::set<CoordinateId> named(coordinates.begin(), coordinates.end());
  const bool all_actuators = std::all_of(mechanism.actuators.begin(), mechanism.actuators.end(),
                                         [&](CoordinateId actuator) { return named.contains(actuator); });
  // a start pose may name more joints than move independently: then the motors' count
  if (coordinates.empty() || (static_cast<int>(coordinates.size()) > freedoms && all_actuators &&
                              static_cast<int>(mechanism.actuators.size()) == freedoms))
    coordinates = mechanism.actuators;
  return coordinates;
}

/// Drive `com`: what is left beside the centre of mass.
void add_remaining(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms, DriveQuantities& chosen) {
  chosen.coordinates = trajectory.remaining_coordinates;
  chosen.tool_angle = chosen.tool_angle || trajectory.remaining_angle;
  if (count_remaining_quantities(trajectory) > 0) return;
  const auto left = [&] { return freedoms - chosen.row_count(); };
  if (mechanism.tool && left() > 0) {
    if (mechanism.space == SpaceKind::planar)
      chosen.tool_angle = true;
    else if (left() >= 3)
      chosen.rotation = {0, 1, 2};
  }
  const int missing = std::clamp(left(), 0, static_cast<int>(mechanism.actuators.size()));
  chosen.coordinates.assign(mechanism.actuators.end() - missing, mechanism.actuators.end());
}

/// What a pose says of joint coordinates; of one that it names twice the last value.
std::map<CoordinateId, double> joint_values(const PoseTarget& pose) {
  std::map<CoordinateId, double> values;
  for (const CoordinateValue& joint : pose.joints) values[joint.coordinate] = joint.value;
  return values;
}

/// The pose says everything that is prescribed.
bool is_fully_prescribed(const DriveQuantities& quantities, const PoseTarget& pose) {
  const std::map<CoordinateId, double> joints = joint_values(pose);
  return (quantities.point.empty() || pose.tool) && (quantities.com.empty() || pose.com) &&
         (!quantities.tool_angle || pose.angle) && (quantities.rotation.empty() || pose.orientation) &&
         std::all_of(quantities.coordinates.begin(), quantities.coordinates.end(),
                     [&](CoordinateId coordinate) { return joints.contains(coordinate); });
}

}  // namespace

DriveQuantities choose_drive_quantities(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms) {
  DriveQuantities chosen;
  const int own = freedoms - count_remaining_quantities(trajectory);
  switch (trajectory.drive) {
    case DriveKind::joints: chosen.coordinates = driven_joints(mechanism, trajectory, freedoms); break;
    case DriveKind::tool:
      if (!mechanism.tool) throw std::invalid_argument("drive: tool needs a `tool:` in the spec");
      add_components(
          trajectory.components.empty() ? default_components(mechanism, trajectory, own) : trajectory.components,
          mechanism, chosen.point, chosen);
      chosen.tool_angle = chosen.tool_angle || trajectory.remaining_angle;
      chosen.coordinates = trajectory.remaining_coordinates;
      break;
    case DriveKind::com: {
      std::vector<Component> components = trajectory.components;
      for (int k = 0; trajectory.components.empty() && k < std::min(own, dimension(mechanism)); ++k)
        components.push_back(static_cast<Component>(k));
      add_components(components, mechanism, chosen.com, chosen);
      add_remaining(mechanism, trajectory, freedoms, chosen);
      break;
    }
  }
  if (chosen.row_count() != freedoms)
    chosen.mismatch = "the drive prescribes " + count_noun(chosen.row_count(), "quantity", "quantities") +
                      ", the mechanism has " + count_noun(freedoms, "degree", "degrees") + " of freedom";
  return chosen;
}

DriveQuantities list_pose_quantities(const Mechanism& mechanism, const PoseTarget& pose) {
  if ((pose.tool || pose.angle || pose.orientation) && !mechanism.tool)
    throw std::invalid_argument("the pose names a tool, but the mechanism has none");
  DriveQuantities stated;
  for (int k = 0; k < dimension(mechanism); ++k) {
    if (pose.tool) stated.point.push_back(k);
    if (pose.com) stated.com.push_back(k);
  }
  stated.tool_angle = pose.angle.has_value() && mechanism.space == SpaceKind::planar;
  if (pose.orientation && mechanism.space == SpaceKind::spatial) stated.rotation = {0, 1, 2};
  for (const CoordinateValue& joint : pose.joints) stated.coordinates.push_back(joint.coordinate);
  return stated;
}

DriveValue read_pose_values(const DriveQuantities& quantities, const PoseTarget& pose, const DriveValue& base) {
  DriveValue out = base;
  int k = 0;
  for (const int component : quantities.point) {
    if (pose.tool) out.value[k] = (*pose.tool)[component];
    ++k;
  }
  for (const int component : quantities.com) {
    if (pose.com) out.value[k] = (*pose.com)[component];
    ++k;
  }
  if (quantities.tool_angle) {
    if (pose.angle) out.value[k] = *pose.angle;
    ++k;
  }
  const std::map<CoordinateId, double> joints = joint_values(pose);
  for (const CoordinateId coordinate : quantities.coordinates) {
    if (const auto stated = joints.find(coordinate); stated != joints.end()) out.value[k] = stated->second;
    ++k;
  }
  if (pose.orientation) out.rotation = *pose.orientation;
  return out;
}

bool is_end_prescribed(const DriveQuantities& quantities, const Trajectory& trajectory) {
  if (std::holds_alternative<TablePath>(trajectory.path) || std::holds_alternative<CirclePath>(trajectory.path) ||
      is_fully_prescribed(quantities, trajectory.to))
    return true;
  // `to` speaks of the drive's own quantities, if not of all of them: the others stay.
  const PoseTarget& to = trajectory.to;
  switch (trajectory.drive) {
    case DriveKind::joints: return !to.joints.empty();
    case DriveKind::tool: return (to.tool || quantities.point.empty()) && trajectory.remaining_coordinates.empty();
    case DriveKind::com: return to.com && !to.tool && to.joints.empty();
  }
  return false;
}

}  // namespace balance
