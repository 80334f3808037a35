#include "balance/motion/drive_choice.hpp"

#include "balance/motion/plan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace balance {

namespace {

std::string count(int n, const char* one, const char* many) { return std::to_string(n) + " " + (n == 1 ? one : many); }

/// Position components by how much they change from the start to the end, largest first (stable).
std::vector<int> most_moving(const Trajectory& trajectory, int dimension) {
  std::vector<int> order(dimension);
  std::iota(order.begin(), order.end(), 0);
  if (trajectory.from.tool && trajectory.to.tool) {
    const Vector3 way = (*trajectory.to.tool - *trajectory.from.tool).cwiseAbs();
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return way[a] > way[b]; });
  }
  return order;
}

/// The tool's components that as many freedoms can follow, positions first.
template <class S>
std::vector<Component> default_components(const Trajectory& trajectory, int freedoms) {
  using enum Component;
  const std::vector<Component> all =
      std::is_same_v<S, Planar> ? std::vector<Component>{x, y, rz} : std::vector<Component>{x, y, z, rx, ry, rz};
  if (freedoms == 4 && std::is_same_v<S, Spatial>) return {x, y, z, rz};
  if (freedoms >= S::dimension)
    return {all.begin(), all.begin() + std::min<std::ptrdiff_t>(freedoms, static_cast<std::ptrdiff_t>(all.size()))};
  if (!trajectory.from.tool && trajectory.from.angle && freedoms == 1) return {rz};
  std::vector<int> moving = most_moving(trajectory, S::dimension);
  moving.resize(freedoms);
  std::sort(moving.begin(), moving.end());
  std::vector<Component> chosen;
  for (const int k : moving) chosen.push_back(all[k]);
  return chosen;
}

template <class S>
void add_components(const std::vector<Component>& components, const Tree<S>& tree, std::vector<int>& place,
                    DriveChoice<S>& choice) {
  for (const Component component : components) {
    const int k = static_cast<int>(component);
    if (k < 3) {
      if (k >= S::dimension) throw std::invalid_argument("a planar mechanism has no component z");
      place.push_back(k);
    } else if constexpr (std::is_same_v<S, Planar>) {
      if (component != Component::rz) throw std::invalid_argument("a planar tool turns about z only");
      choice.tool_angle = true;
      choice.drive.linear.push_back(tool_angle(tree, choice.drive.tool));
    } else {
      choice.drive.rotation.push_back(k - 3);
    }
  }
}

template <class S>
void add_coordinates(const std::vector<int>& coordinates, const Mechanism& mechanism, const Tree<S>& tree,
                     DriveChoice<S>& choice) {
  for (const int coordinate : coordinates) {
    choice.coordinates.push_back(coordinate);
    choice.drive.linear.push_back(coordinate_row(mechanism, tree, coordinate));
  }
}

std::vector<int> named_joints(const Trajectory& trajectory) {
  std::vector<int> coordinates;
  for (const CoordinateValue& value : trajectory.from.joints) coordinates.push_back(value.coordinate);
  return coordinates;
}

/// Drive `joints`: what `from` names, or the actuators.
std::vector<int> driven_joints(const Mechanism& mechanism, const Trajectory& trajectory, int freedoms) {
  std::vector<int> coordinates = named_joints(trajectory);
  const bool all_actuators = std::all_of(mechanism.actuators.begin(), mechanism.actuators.end(), [&](int actuator) {
    return std::find(coordinates.begin(), coordinates.end(), actuator) != coordinates.end();
  });
  // a start pose may name more joints than move independently: then the motors' count
  if (coordinates.empty() || (static_cast<int>(coordinates.size()) > freedoms && all_actuators &&
                              static_cast<int>(mechanism.actuators.size()) == freedoms))
    coordinates = mechanism.actuators;
  return coordinates;
}

/// Drive `com`: what is left beside the centre of mass.
template <class S>
void add_remaining(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory, int freedoms,
                   DriveChoice<S>& choice) {
  if (!trajectory.remaining.empty()) return add_coordinates(trajectory.remaining, mechanism, tree, choice);
  const auto left = [&] { return freedoms - choice.drive.rows(); };
  if (mechanism.tool && left() > 0) {
    if constexpr (std::is_same_v<S, Planar>)
      add_components<S>({Component::rz}, tree, choice.drive.com, choice);
    else if (left() >= 3)
      choice.drive.rotation = {0, 1, 2};
  }
  const int missing = std::clamp(left(), 0, static_cast<int>(mechanism.actuators.size()));
  add_coordinates<S>({mechanism.actuators.end() - missing, mechanism.actuators.end()}, mechanism, tree, choice);
}

}  // namespace

template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            int freedoms) {
  DriveChoice<S> choice;
  attach_tool(mechanism, tree, choice.drive);
  const int own = freedoms - static_cast<int>(trajectory.remaining.size());
  switch (trajectory.drive) {
    case DriveKind::joints:
      add_coordinates(driven_joints(mechanism, trajectory, freedoms), mechanism, tree, choice);
      break;
    case DriveKind::tool:
      if (!mechanism.tool) throw std::invalid_argument("drive: tool needs a `tool:` in the spec");
      add_components(trajectory.components.empty() ? default_components<S>(trajectory, own) : trajectory.components,
                     tree, choice.drive.point, choice);
      add_coordinates(trajectory.remaining, mechanism, tree, choice);
      break;
    case DriveKind::com: {
      std::vector<Component> components = trajectory.components;
      for (int k = 0; trajectory.components.empty() && k < std::min(own, S::dimension); ++k)
        components.push_back(static_cast<Component>(k));
      add_components(components, tree, choice.drive.com, choice);
      add_remaining(mechanism, tree, trajectory, freedoms, choice);
      break;
    }
  }
  const int rows = choice.drive.rows();
  if (rows != freedoms)
    choice.mismatch = "the drive prescribes " + count(rows, "quantity", "quantities") + ", the mechanism has " +
                      count(freedoms, "degree", "degrees") + " of freedom";
  return choice;
}

template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&, int);
template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&, int);

}  // namespace balance
