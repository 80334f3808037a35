#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include <cmath>
#include <stdexcept>

namespace balance::kinematics {

template <class S>
LinearQuantityOf<typename S::Scalar> find_coordinate_expression(const MechanismOf<typename S::Scalar>& mechanism,
                                                                const Tree<S>& tree, CoordinateId coordinate) {
  if (!tree.coordinate_expressions[coordinate].has_terms())
    throw std::invalid_argument("coordinate " + mechanism.coordinates[coordinate].name + " was cut");
  return tree.coordinate_expressions[coordinate];
}

template <class T>
LinearQuantityOf<T> make_tool_angle_expression(const Tree<PlanarOf<T>>& tree, const FixedFrame<PlanarOf<T>>& tool) {
  LinearQuantityOf<T> angle;
  using elementary::atan2;
  angle.constant = atan2(tool.R_N.s, tool.R_N.c);
  for (int n = tool.node; n > 0; n = tree.nodes[n].parent) {
    const Node<PlanarOf<T>>& node = tree.nodes[n];
    angle.constant += atan2(node.R_PF.s, node.R_PF.c);
    if (node.motion != NodeMotion::revolute) continue;
    angle.constant += node.offset;
    angle.terms.emplace_back(node.column, node.ratio);
  }
  return angle;
}

template <class S>
void set_tool_frame(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree, Drive<S>& drive) {
  if (!mechanism.tool) return;
  const FixedFrame<S>& body = tree.bodies[mechanism.tool->body];
  drive.tool = {body.node, body.R_N, body.p_N + body.R_N * to_vector<S>(mechanism.tool->position)};
  drive.tool_path.clear();
  for (int n = drive.tool.node; n > 0; n = tree.nodes[n].parent)
    if (tree.nodes[n].motion != NodeMotion::weld) drive.tool_path.push_back(n);
}

template <class S>
Drive<S> make_drive(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                    const trajectory::DriveQuantities& quantities) {
  Drive<S> drive;
  set_tool_frame(mechanism, tree, drive);
  drive.point = quantities.point;
  drive.com = quantities.com;
  drive.rotation = quantities.rotation;
  if constexpr (is_planar<S>)
    if (quantities.tool_angle) drive.linear.push_back(make_tool_angle_expression(tree, drive.tool));
  for (const CoordinateId coordinate : quantities.coordinates)
    drive.linear.push_back(find_coordinate_expression(mechanism, tree, coordinate));
  return drive;
}

template <class S>
PoseEquations<S> make_pose_equations(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree,
                                     const trajectory::PoseTargetOf<typename S::Scalar>& pose) {
  using T = typename S::Scalar;
  PoseEquations<S> equations;
  Drive<S>& drive = equations.drive;
  std::vector<T> values;
  set_tool_frame(mechanism, tree, drive);
  if ((pose.tool || pose.angle || pose.orientation) && !mechanism.tool)
    throw std::invalid_argument("the pose names a tool, but the mechanism has none");
  for (int k = 0; pose.tool && k < S::dimension; ++k) drive.point.push_back(k), values.push_back((*pose.tool)[k]);
  for (int k = 0; pose.com && k < S::dimension; ++k) drive.com.push_back(k), values.push_back((*pose.com)[k]);
  if constexpr (is_planar<S>) {
    if (pose.angle) drive.linear.push_back(make_tool_angle_expression(tree, drive.tool)), values.push_back(*pose.angle);
  } else if (pose.orientation) {
    drive.rotation = {0, 1, 2};
    equations.target.rotation = *pose.orientation;
  }
  for (const model::CoordinateValueOf<T>& joint : pose.joints) {
    drive.linear.push_back(find_coordinate_expression(mechanism, tree, joint.coordinate));
    values.push_back(joint.value);
  }
  equations.target.value = Eigen::Map<const VectorXOf<T>>(values.data(), static_cast<Eigen::Index>(values.size()));
  return equations;
}

template LinearQuantityOf<EngineScalar> find_coordinate_expression<PlanarOf<EngineScalar>>(
    const MechanismOf<EngineScalar>&, const Tree<PlanarOf<EngineScalar>>&, CoordinateId);
template LinearQuantityOf<EngineScalar> find_coordinate_expression<SpatialOf<EngineScalar>>(
    const MechanismOf<EngineScalar>&, const Tree<SpatialOf<EngineScalar>>&, CoordinateId);
template LinearQuantityOf<EngineScalar> make_tool_angle_expression<EngineScalar>(
    const Tree<PlanarOf<EngineScalar>>&, const FixedFrame<PlanarOf<EngineScalar>>&);
template void set_tool_frame<PlanarOf<EngineScalar>>(const MechanismOf<EngineScalar>&,
                                                     const Tree<PlanarOf<EngineScalar>>&,
                                                     Drive<PlanarOf<EngineScalar>>&);
template void set_tool_frame<SpatialOf<EngineScalar>>(const MechanismOf<EngineScalar>&,
                                                      const Tree<SpatialOf<EngineScalar>>&,
                                                      Drive<SpatialOf<EngineScalar>>&);
template Drive<PlanarOf<EngineScalar>> make_drive<PlanarOf<EngineScalar>>(const MechanismOf<EngineScalar>&,
                                                                          const Tree<PlanarOf<EngineScalar>>&,
                                                                          const trajectory::DriveQuantities&);
template Drive<SpatialOf<EngineScalar>> make_drive<SpatialOf<EngineScalar>>(const MechanismOf<EngineScalar>&,
                                                                            const Tree<SpatialOf<EngineScalar>>&,
                                                                            const trajectory::DriveQuantities&);
template PoseEquations<PlanarOf<EngineScalar>> make_pose_equations<PlanarOf<EngineScalar>>(
    const MechanismOf<EngineScalar>&, const Tree<PlanarOf<EngineScalar>>&,
    const trajectory::PoseTargetOf<EngineScalar>&);
template PoseEquations<SpatialOf<EngineScalar>> make_pose_equations<SpatialOf<EngineScalar>>(
    const MechanismOf<EngineScalar>&, const Tree<SpatialOf<EngineScalar>>&,
    const trajectory::PoseTargetOf<EngineScalar>&);

}  // namespace balance::kinematics
