#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/plan.hpp"

#include "balance/base/rotation.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

/// y-independent part of a coordinate or tool angle: q = ratio · y[column] + offset.
LinearQuantity coordinate_quantity(const Mechanism& mechanism, const CoordinateSource& source, int coordinate) {
  LinearQuantity quantity;
  quantity.terms.emplace_back(source.column, source.ratio);
  quantity.constant = source.offset;
  quantity.is_length = mechanism.coordinates[coordinate].kind == CoordinateKind::length;
  return quantity;
}

/// First guess of y from the assembly values of tree coordinates.
template <class S>
VectorX assembly_guess(const Mechanism& mechanism, const Tree<S>& tree) {
  VectorX y = VectorX::Zero(tree.columns);
  for (const CoordinateValue& rough : mechanism.assembly) {
    const CoordinateSource& source = tree.sources[rough.coordinate];
    if (source.column >= 0 && source.ratio != 0) y[source.column] = (rough.value - source.offset) / source.ratio;
  }
  return y;
}

}  // namespace

template <class S>
LinearQuantity coordinate_row(const Mechanism& mechanism, const Tree<S>& tree, int coordinate) {
  const CoordinateSource& source = tree.sources[coordinate];
  if (source.column < 0)
    throw std::invalid_argument("coordinate " + mechanism.coordinates[coordinate].name + " was cut");
  return coordinate_quantity(mechanism, source, coordinate);
}

LinearQuantity tool_angle(const Tree<Planar>& tree, const FixedFrame<Planar>& tool) {
  LinearQuantity angle;
  angle.constant = std::atan2(tool.R_N.s, tool.R_N.c);
  for (int n = tool.node; n > 0; n = tree.nodes[n].parent) {
    const Node<Planar>& node = tree.nodes[n];
    angle.constant += std::atan2(node.R_PF.s, node.R_PF.c);
    if (node.motion != NodeMotion::turn) continue;
    angle.constant += node.offset;
    angle.terms.emplace_back(node.column, node.ratio);
  }
  return angle;
}

template <class S>
void attach_tool(const Mechanism& mechanism, const Tree<S>& tree, Drive<S>& drive) {
  if (!mechanism.tool) return;
  const FixedFrame<S>& body = tree.bodies[mechanism.tool->body];
  drive.tool = {body.node, body.R_N, body.p_N + body.R_N * to_vector<S>(mechanism.tool->position)};
  drive.tool_path.clear();
  for (int n = drive.tool.node; n > 0; n = tree.nodes[n].parent)
    if (tree.nodes[n].motion != NodeMotion::weld) drive.tool_path.push_back(n);
}

template <class S>
PoseEquations<S> pose_equations(const Mechanism& mechanism, const Tree<S>& tree, const PoseTarget& pose) {
  PoseEquations<S> equations;
  Drive<S>& drive = equations.drive;
  std::vector<double> values;
  attach_tool(mechanism, tree, drive);
  if ((pose.tool || pose.angle || pose.orientation) && !mechanism.tool)
    throw std::invalid_argument("the pose names a tool, but the mechanism has none");
  for (int k = 0; pose.tool && k < S::dimension; ++k) drive.point.push_back(k), values.push_back((*pose.tool)[k]);
  for (int k = 0; pose.com && k < S::dimension; ++k) drive.com.push_back(k), values.push_back((*pose.com)[k]);
  if constexpr (std::is_same_v<S, Planar>) {
    if (pose.angle) drive.linear.push_back(tool_angle(tree, drive.tool)), values.push_back(*pose.angle);
  } else if (pose.orientation) {
    drive.rotation = {0, 1, 2};
    equations.target.rotation = *pose.orientation;
  }
  for (const CoordinateValue& joint : pose.joints) {
    drive.linear.push_back(coordinate_row(mechanism, tree, joint.coordinate));
    values.push_back(joint.value);
  }
  equations.target.value = Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
  return equations;
}

template <class S>
double distance_from_assembly(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  if (mechanism.assembly.empty()) return 0;
  State<S> state(tree.nodes.size());
  poses(tree, y.data(), state);
  double sum = 0;
  for (const CoordinateValue& rough : mechanism.assembly) {
    const Coordinate& coordinate = mechanism.coordinates[rough.coordinate];
    const CoordinateSource& source = tree.sources[rough.coordinate];
    double value;
    if (source.column >= 0 && !tree.joint_floats[coordinate.joint]) {
      value = source.ratio * y[source.column] + source.offset;
    } else {
      const Joint& joint = mechanism.joints[coordinate.joint];
      value = read_joint(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    }
    const double off = coordinate.kind == CoordinateKind::angle ? rough.value - unwrapped(value, rough.value)
                                                                : (rough.value - value) / tree.length;
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(mechanism.assembly.size()));
}

template <class S>
Solution find_pose(const Mechanism& mechanism, const Tree<S>& tree, System<S>& system, const DriveSample& target) {
  // At the assembly values the first solution is the one; near them a few tries tell whether there is a nearer one, since one joint's
  // other mode need not be far on the mean of many; elsewhere the nearest of many is taken.
  constexpr double at = 0.1, near = 0.4;
  constexpr std::uint64_t few = 20, many = 200;
  const VectorX guess = assembly_guess(mechanism, tree);
  Solution best = solve(system, guess, target);
  double distance = best.found ? distance_from_assembly(mechanism, tree, best.y) : INFINITY;
  for (std::uint64_t seed = 1; seed <= (distance > near ? many : few) && distance > at; ++seed) {
    const VectorX random = random_coordinates(tree, seed);
    // the first restarts stay near the guess, later ones go anywhere
    const double spread = seed <= 60 ? 0.1 + 0.01 * static_cast<double>(seed) : 1;
    const Solution trial = solve(system, spread < 1 ? VectorX(guess + spread * random) : random, target);
    if (!trial.found) {
      if (!best.found && trial.residual < best.residual) best = trial;
      continue;
    }
    const double off = distance_from_assembly(mechanism, tree, trial.y);
    if (!best.found || off < distance) best = trial, distance = off;
  }
  return best;
}

#define BALANCE_INSTANTIATE(S)                                                                      \
  template PoseEquations<S> pose_equations<S>(const Mechanism&, const Tree<S>&, const PoseTarget&); \
  template double distance_from_assembly<S>(const Mechanism&, const Tree<S>&, const VectorX&);      \
  template Solution find_pose<S>(const Mechanism&, const Tree<S>&, System<S>&, const DriveSample&); \
  template void attach_tool<S>(const Mechanism&, const Tree<S>&, Drive<S>&);                        \
  template LinearQuantity coordinate_row<S>(const Mechanism&, const Tree<S>&, int);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
