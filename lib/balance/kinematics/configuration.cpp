#include "balance/kinematics/joint_coordinates.hpp"

namespace balance {

template <class S>
std::vector<double> compute_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  TreeState<S> state(tree.nodes.size());
  compute_poses(tree, y.data(), state);
  std::vector<double> values;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const LinearQuantity& source = tree.coordinate_expressions[c];
    const Joint& joint = mechanism.joints[coordinate.joint];
    const double value =
        source.has_terms() && !tree.is_floating[c]
            ? source.value(y.data())
            : compute_joint_motion(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    values.push_back(coordinate.kind == CoordinateKind::angle ? unwrap_angle(value, 0) : value);
  }
  return values;
}

template std::vector<double> compute_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
template std::vector<double> compute_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&, const VectorX&);

}  // namespace balance
