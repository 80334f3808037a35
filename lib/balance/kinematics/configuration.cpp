#include "balance/kinematics/joint_coordinates.hpp"

namespace balance {

template <class S>
std::vector<double> read_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  State<S> state(tree.nodes.size());
  poses(tree, y.data(), state);
  std::vector<double> values;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const LinearQuantity& source = tree.sources[c];
    const Joint& joint = mechanism.joints[coordinate.joint];
    const double value = source.depends() && !tree.floats[c]
                             ? source.value(y.data())
                             : read_joint(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    values.push_back(coordinate.kind == CoordinateKind::angle ? unwrapped(value, 0) : value);
  }
  return values;
}

template std::vector<double> read_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
template std::vector<double> read_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&, const VectorX&);

}  // namespace balance
