#include "balance/base/elementary.hpp"
#include "balance/base/number.hpp"
#include "balance/motion/plan.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

template <class S>
LinearQuantityOf<typename S::Scalar> coordinate_row(const MechanismOf<typename S::Scalar>& mechanism,
                                                    const Tree<S>& tree, CoordinateId coordinate) {
  if (!tree.sources[coordinate].depends())
    throw std::invalid_argument("coordinate " + mechanism.coordinates[coordinate].name + " was cut");
  return tree.sources[coordinate];
}

template <class T>
LinearQuantityOf<T> tool_angle(const Tree<PlanarOf<T>>& tree, const FixedFrame<PlanarOf<T>>& tool) {
  LinearQuantityOf<T> angle;
  using elementary::atan2;
  angle.constant = atan2(tool.R_N.s, tool.R_N.c);
  for (int n = tool.node; n > 0; n = tree.nodes[n].parent) {
    const Node<PlanarOf<T>>& node = tree.nodes[n];
    angle.constant += atan2(node.R_PF.s, node.R_PF.c);
    if (node.motion != NodeMotion::turn) continue;
    angle.constant += node.offset;
    angle.terms.emplace_back(node.column, node.ratio);
  }
  return angle;
}

template <class S>
void attach_tool(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree, Drive<S>& drive) {
  if (!mechanism.tool) return;
  const FixedFrame<S>& body = tree.bodies[mechanism.tool->body];
  drive.tool = {body.node, body.R_N, body.p_N + body.R_N * to_vector<S>(mechanism.tool->position)};
  drive.tool_path.clear();
  for (int n = drive.tool.node; n > 0; n = tree.nodes[n].parent)
    if (tree.nodes[n].motion != NodeMotion::weld) drive.tool_path.push_back(n);
}

template <class S>
Drive<S> drive_rows(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                    const DriveQuantities& quantities) {
  Drive<S> drive;
  attach_tool(mechanism, tree, drive);
  drive.point = quantities.point;
  drive.com = quantities.com;
  drive.rotation = quantities.rotation;
  if constexpr (is_planar<S>)
    if (quantities.tool_angle) drive.linear.push_back(tool_angle(tree, drive.tool));
  for (const CoordinateId coordinate : quantities.coordinates)
    drive.linear.push_back(coordinate_row(mechanism, tree, coordinate));
  return drive;
}

template <class S>
PoseEquations<S> pose_equations(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                                const PoseTargetOf<typename S::Scalar>& pose) {
  using T = typename S::Scalar;
  PoseEquations<S> equations;
  Drive<S>& drive = equations.drive;
  std::vector<T> values;
  attach_tool(mechanism, tree, drive);
  if ((pose.tool || pose.angle || pose.orientation) && !mechanism.tool)
    throw std::invalid_argument("the pose names a tool, but the mechanism has none");
  for (int k = 0; pose.tool && k < S::dimension; ++k) drive.point.push_back(k), values.push_back((*pose.tool)[k]);
  for (int k = 0; pose.com && k < S::dimension; ++k) drive.com.push_back(k), values.push_back((*pose.com)[k]);
  if constexpr (is_planar<S>) {
    if (pose.angle) drive.linear.push_back(tool_angle(tree, drive.tool)), values.push_back(*pose.angle);
  } else if (pose.orientation) {
    drive.rotation = {0, 1, 2};
    equations.target.rotation = *pose.orientation;
  }
  for (const CoordinateValueOf<T>& joint : pose.joints) {
    drive.linear.push_back(coordinate_row(mechanism, tree, joint.coordinate));
    values.push_back(joint.value);
  }
  equations.target.value = Eigen::Map<const VectorXOf<T>>(values.data(), static_cast<Eigen::Index>(values.size()));
  return equations;
}

template LinearQuantityOf<Number> coordinate_row<PlanarOf<Number>>(const MechanismOf<Number>&,
                                                                   const Tree<PlanarOf<Number>>&, CoordinateId);
template LinearQuantityOf<Number> coordinate_row<SpatialOf<Number>>(const MechanismOf<Number>&,
                                                                    const Tree<SpatialOf<Number>>&, CoordinateId);
template LinearQuantityOf<Number> tool_angle<Number>(const Tree<PlanarOf<Number>>&,
                                                     const FixedFrame<PlanarOf<Number>>&);
template void attach_tool<PlanarOf<Number>>(const MechanismOf<Number>&, const Tree<PlanarOf<Number>>&,
                                            Drive<PlanarOf<Number>>&);
template void attach_tool<SpatialOf<Number>>(const MechanismOf<Number>&, const Tree<SpatialOf<Number>>&,
                                             Drive<SpatialOf<Number>>&);
template Drive<PlanarOf<Number>> drive_rows<PlanarOf<Number>>(const MechanismOf<Number>&, const Tree<PlanarOf<Number>>&,
                                                              const DriveQuantities&);
template Drive<SpatialOf<Number>> drive_rows<SpatialOf<Number>>(const MechanismOf<Number>&,
                                                                const Tree<SpatialOf<Number>>&, const DriveQuantities&);
template PoseEquations<PlanarOf<Number>> pose_equations<PlanarOf<Number>>(const MechanismOf<Number>&,
                                                                          const Tree<PlanarOf<Number>>&,
                                                                          const PoseTargetOf<Number>&);
template PoseEquations<SpatialOf<Number>> pose_equations<SpatialOf<Number>>(const MechanismOf<Number>&,
                                                                            const Tree<SpatialOf<Number>>&,
                                                                            const PoseTargetOf<Number>&);

}  // namespace balance
