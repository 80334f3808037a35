#include "balance/mechanics/trajectory/drive_quantities.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace balance::trajectory {

bool drives_nothing(const Trajectory& trajectory) {
  if (!trajectory.free_motion || trajectory.drive != DriveKind::joints) return false;
  return trajectory.from.joints.size() == trajectory.free_motion->free.size() + trajectory.free_motion->held.size();
}

const char* drive_name(const Trajectory& trajectory) {
  return drives_nothing(trajectory) ? "none" : name_of(trajectory.drive);
}

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
  if (const auto* waypoints = std::get_if<WaypointPath>(&trajectory.path))
    for (const PoseTarget& point : waypoints->points) add(point);
  return coordinates;
}

namespace {

int dimension(const Mechanism& mechanism) { return mechanism.space == SpaceKind::planar ? 2 : 3; }

/// Position components in decreasing order of their change from start to end (stable).
std::vector<int> order_by_displacement(const Trajectory& trajectory, int dimension) {
  std::vector<int> order(dimension);
  std::iota(order.begin(), order.end(), 0);
  if (trajectory.from.tool && trajectory.to.tool) {
    const Vector3 displacement = (*trajectory.to.tool - *trajectory.from.tool).cwiseAbs();
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return displacement[a] > displacement[b]; });
  }
  return order;
}

/// Default components of the tool for a number of freedoms, positions first.
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
  std::vector<Component> components;
  for (const int k : moving) components.push_back(all[k]);
  return components;
}

void add_components(const std::vector<Component>& components, const Mechanism& mechanism,
                    std::vector<int>& position_components, DriveQuantities& quantities) {
  const bool planar = mechanism.space == SpaceKind::planar;
  for (const Component component : components) {
    const int k = static_cast<int>(component);
    if (k < 3) {
      if (k >= dimension(mechanism)) throw std::invalid_argument("a planar mechanism has no component z");
      position_components.push_back(k);
    } else if (planar) {
      if (component != Component::rz) throw std::invalid_argument("a planar tool turns about z only");
      quantities.tool_angle = true;
    } else {
      quantities.rotation.push_back(k - 3);
    }
  }
}

bool has_course(const Trajectory& trajectory, CoordinateId coordinate) {
  return std::any_of(trajectory.courses.begin(), trajectory.courses.end(),
                     [&](const CoordinateCourse& course) { return course.coordinate == coordinate; });
}

/// The coordinates without a course.
std::vector<CoordinateId> drop_courses(std::vector<CoordinateId> coordinates, const Trajectory& trajectory) {
  std::erase_if(coordinates, [&](CoordinateId coordinate) { return has_course(trajectory, coordinate); });
  return coordinates;
}

/// Coordinates for which a pose has a value, without those with a course.
std::vector<CoordinateId> named_joints(const PoseTarget& pose, const Trajectory& trajectory) {
  std::vector<CoordinateId> coordinates;
  for (const CoordinateValue& value : pose.joints) coordinates.push_back(value.coordinate);
  return drop_courses(std::move(coordinates), trajectory);
}

/// Drive `joints`: the coordinates named by `from`, or the actuated ones.
std::vector<CoordinateId> driven_joints(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms) {
  std::vector<CoordinateId> coordinates = named_joints(trajectory.from, trajectory);
  const std::vector<CoordinateId> actuators = drop_courses(mechanism.actuators, trajectory);
  const std::set<CoordinateId> named(coordinates.begin(), coordinates.end());
  const bool all_actuators =
      std::all_of(actuators.begin(), actuators.end(), [&](CoordinateId actuator) { return named.contains(actuator); });
  // a start pose may name more joints than there are freedoms: use the actuators then
  if (coordinates.empty() || (static_cast<int>(coordinates.size()) > freedoms && all_actuators &&
                              static_cast<int>(actuators.size()) == freedoms))
    coordinates = actuators;
  return coordinates;
}

/// Drive `com`: quantities in addition to the centre of mass.
void add_remaining(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms,
                   DriveQuantities& quantities) {
  quantities.coordinates = trajectory.remaining_coordinates;
  quantities.tool_angle = quantities.tool_angle || trajectory.remaining_angle;
  if (count_remaining_quantities(trajectory) > 0) return;
  const auto remaining_count = [&] { return freedoms - quantities.row_count(); };
  if (mechanism.tool && remaining_count() > 0) {
    if (mechanism.space == SpaceKind::planar)
      quantities.tool_angle = true;
    else if (remaining_count() >= 3)
      quantities.rotation = {0, 1, 2};
  }
  const std::vector<CoordinateId> actuators = drop_courses(mechanism.actuators, trajectory);
  const int missing = std::clamp(remaining_count(), 0, static_cast<int>(actuators.size()));
  quantities.coordinates.assign(actuators.end() - missing, actuators.end());
}

/// Joint coordinates specified by a pose; of duplicates, the last value.
std::map<CoordinateId, double> joint_values(const PoseTarget& pose) {
  std::map<CoordinateId, double> values;
  for (const CoordinateValue& joint : pose.joints) values[joint.coordinate] = joint.value;
  return values;
}

/// Whether the pose specifies everything that is prescribed.
bool is_fully_prescribed(const DriveQuantities& quantities, const PoseTarget& pose) {
  const std::map<CoordinateId, double> joints = joint_values(pose);
  return (quantities.point.empty() || pose.tool) && (quantities.com.empty() || pose.com) &&
         (!quantities.tool_angle || pose.angle) && (quantities.rotation.empty() || pose.orientation) &&
         std::all_of(quantities.coordinates.begin(), quantities.coordinates.end(),
                     [&](CoordinateId coordinate) { return joints.contains(coordinate); });
}

}  // namespace

DriveQuantities choose_drive_quantities(const Mechanism& mechanism, const Trajectory& trajectory,
                                        int mechanism_freedoms) {
  DriveQuantities quantities;
  const int freedoms = mechanism_freedoms - static_cast<int>(trajectory.courses.size()),
            own_count = freedoms - count_remaining_quantities(trajectory);
  switch (trajectory.drive) {
    case DriveKind::joints: quantities.coordinates = driven_joints(mechanism, trajectory, freedoms); break;
    case DriveKind::tool:
      if (!mechanism.tool) throw std::invalid_argument("drive: tool needs a `tool:` in the spec");
      add_components(
          trajectory.components.empty() ? default_components(mechanism, trajectory, own_count) : trajectory.components,
          mechanism, quantities.point, quantities);
      quantities.tool_angle = quantities.tool_angle || trajectory.remaining_angle;
      quantities.coordinates = trajectory.remaining_coordinates;
      break;
    case DriveKind::com: {
      std::vector<Component> components = trajectory.components;
      for (int k = 0; trajectory.components.empty() && k < std::min(own_count, dimension(mechanism)); ++k)
        components.push_back(static_cast<Component>(k));
      add_components(components, mechanism, quantities.com, quantities);
      add_remaining(mechanism, trajectory, freedoms, quantities);
      break;
    }
  }
  if (quantities.row_count() != freedoms)
    quantities.mismatch = "the drive prescribes " + count_noun(quantities.row_count(), "quantity", "quantities") +
                          ", the mechanism has " + count_noun(freedoms, "degree", "degrees") + " of freedom";
  for (const CoordinateCourse& course : trajectory.courses) quantities.coordinates.push_back(course.coordinate);
  return quantities;
}

DriveQuantities list_pose_quantities(const Mechanism& mechanism, const PoseTarget& pose) {
  if ((pose.tool || pose.angle || pose.orientation) && !mechanism.tool)
    throw std::invalid_argument("the pose names a tool, but the mechanism has none");
  DriveQuantities quantities;
  for (int k = 0; k < dimension(mechanism); ++k) {
    if (pose.tool) quantities.point.push_back(k);
    if (pose.com) quantities.com.push_back(k);
  }
  quantities.tool_angle = pose.angle.has_value() && mechanism.space == SpaceKind::planar;
  if (pose.orientation && mechanism.space == SpaceKind::spatial) quantities.rotation = {0, 1, 2};
  for (const CoordinateValue& joint : pose.joints) quantities.coordinates.push_back(joint.coordinate);
  return quantities;
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
    if (const auto joint_value = joints.find(coordinate); joint_value != joints.end())
      out.value[k] = joint_value->second;
    ++k;
  }
  if (pose.orientation) out.rotation = *pose.orientation;
  return out;
}

bool is_end_prescribed(const DriveQuantities& quantities, const Trajectory& trajectory) {
  if (std::holds_alternative<TablePath>(trajectory.path) || std::holds_alternative<CirclePath>(trajectory.path) ||
      is_fully_prescribed(quantities, trajectory.to))
    return true;
  // `to` specifies some of the drive's own quantities: the others keep their values.
  const PoseTarget& to = trajectory.to;
  const bool has_joints = !named_joints(to, trajectory).empty();
  switch (trajectory.drive) {
    case DriveKind::joints: return has_joints;
    case DriveKind::tool: return (to.tool || quantities.point.empty()) && trajectory.remaining_coordinates.empty();
    case DriveKind::com: return to.com && !to.tool && !has_joints;
  }
  return false;
}

namespace {

/// A circle or arc projected onto the coordinate plane of two components.
Path project_path(Path path, int a, int b) {
  const auto project = [&](const Vector3& v) { return Vector3(v[a], v[b], 0); };
  if (auto* circle = std::get_if<CirclePath>(&path)) {
    const Vector3 plane_normal = Vector3::Unit(a).cross(Vector3::Unit(b));
    circle->normal = project(circle->normal) + circle->normal.dot(plane_normal) * Vector3::UnitZ();
    circle->centre = project(circle->centre);
  } else if (auto* arc = std::get_if<ArcPath>(&path)) {
    arc->via = project(arc->via);
  }
  return path;
}

}  // namespace

PrescribedMotion::Request make_prescribed_motion_request(const Trajectory& trajectory,
                                                         const DriveQuantities& quantities, DriveValue from,
                                                         DriveValue to) {
  PrescribedMotion::Request request;
  request.law = trajectory.law;
  request.duration = find_trajectory_duration(trajectory);
  request.from = std::move(from), request.to = std::move(to);
  const std::vector<int>& components = quantities.point.empty() ? quantities.com : quantities.point;
  request.position_components = components.size() < 2 ? 0 : static_cast<int>(components.size());
  request.path = components.size() == 2 ? project_path(trajectory.path, components[0], components[1]) : trajectory.path;
  request.has_rotation = !quantities.rotation.empty();
  if (const auto* waypoints = std::get_if<WaypointPath>(&trajectory.path))
    for (const PoseTarget& point : waypoints->points)
      request.via.push_back(
          read_pose_values(quantities, point, request.via.empty() ? request.from : request.via.back()));
  add_courses(trajectory, quantities, request);
  add_secondary_tasks(trajectory, quantities, request);
  return request;
}

}  // namespace balance::trajectory
