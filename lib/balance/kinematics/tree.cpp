#include "balance/kinematics/tree.hpp"

#include "balance/base/number.hpp"
#include "balance/base/rotation.hpp"
#include "balance/kinematics/joint_steps.hpp"
#include "balance/kinematics/rate_closures.hpp"
#include "balance/model/conversion.hpp"
#include "balance/model/coupling_roots.hpp"
#include "balance/model/incidence.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <type_traits>

namespace balance {

template <class S>
typename S::Inertia inertia_about_origin(const typename S::Scalar& mass, const Vector3Of<typename S::Scalar>& com,
                                         const Matrix3Of<typename S::Scalar>& about_com) {
  using T = typename S::Scalar;
  if constexpr (is_planar<S>)
    return {mass, mass * com.template head<2>(), about_com(2, 2) + mass * com.template head<2>().squaredNorm()};
  else
    return {mass, mass * com,
            about_com + mass * (com.squaredNorm() * Matrix3Of<T>::Identity() - com * com.transpose())};
}

template <class S>
typename S::Inertia transform_inertia(const typename S::Inertia& inertia, const typename S::Rotation& R,
                                      const typename S::Vector& p) {
  using T = typename S::Scalar;
  const typename S::Vector moment = R * inertia.first_moment;
  if constexpr (is_planar<S>) {
    return {inertia.mass, moment + inertia.mass * p,
            inertia.second_moment + 2 * p.dot(moment) + inertia.mass * p.squaredNorm()};
  } else {
    const Matrix3Of<T> second = R.matrix * inertia.second_moment * R.matrix.transpose();
    const Matrix3Of<T> E = Matrix3Of<T>::Identity();
    return {inertia.mass, moment + inertia.mass * p,
            second + 2 * p.dot(moment) * E - p * moment.transpose() - moment * p.transpose() +
                inertia.mass * (p.squaredNorm() * E - p * p.transpose())};
  }
}

namespace {

template <class S>
class TreeCompiler {
 public:
  using T = typename S::Scalar;

  TreeCompiler(const MechanismOf<T>& mechanism, const std::vector<CoordinateId>& needed) : mechanism_(mechanism) {
    const Mechanism& values = values_of(mechanism);
    coordinates_ = coordinates_of_joints(values);
    needed_ = find_needed_joints(values, needed);
    spanning_ = build_spanning_tree(values, needed);
    if (mechanism.space == SpaceKind::spatial) tree_.locked_freedoms = locked_freedoms(values, needed, spanning_);
    tree_.characteristic_length = characteristic_length(values);
  }

  Tree<S> run() {
    tree_.nodes.emplace_back();
    tree_.bodies.resize(mechanism_.bodies.size());
    tree_.joint_nodes.assign(mechanism_.joints.size(), -1);
    tree_.joint_forward.assign(mechanism_.joints.size(), true);
    tree_.is_floating.assign(mechanism_.coordinates.size(), false);
    number_columns();
    for (const TreeEdge& edge : spanning_.edges) add_joint(edge);
    for (const JointId joint : spanning_.cut) add_closure(joint);
    add_mass_elements();
    for (const TreeEdge& edge : spanning_.edges)
      if (const JointOf<T>& joint = mechanism_.joints[edge.joint]; is_rolling(joint.type) && !joint.slips)
        tree_.closures.push_back(make_rolling_closure(tree_, joint, edge.joint));
    for (const GeneralisedSpeedOf<T>& constraint : mechanism_.constraints)
      tree_.closures.push_back(make_speed_closure(tree_, constraint));
    for (Closure<S>& closure : tree_.closures) {
      if (closure.terms.empty()) find_path(closure);
      tree_.closure_rows += static_cast<int>(closure.rows.size());
      if (!closure.is_velocity_level()) tree_.position_rows = tree_.closure_rows;
      closure.has_coincident_origins =
          std::count_if(closure.rows.begin(), closure.rows.end(),
                        [](const ClosureRow& row) { return row.kind == ClosureRow::Kind::along; }) == S::dimension;
      tree_.has_sliding_closures = tree_.has_sliding_closures || !closure.has_coincident_origins;
    }
    return std::move(tree_);
  }

 private:
  void number_columns() {
    std::vector<bool> in_tree(mechanism_.joints.size(), false);
    for (const TreeEdge& edge : spanning_.edges) in_tree[edge.joint] = true;
    std::map<int, int> columns;
    const std::vector<ResolvedCouplingOf<T>> roots = resolve_couplings(mechanism_);
    tree_.coordinate_expressions.resize(mechanism_.coordinates.size());
    // columns in the order of the tree keep the loops' blocks together
    for (const TreeEdge& edge : spanning_.edges)
      for (const int c : coordinates_[edge.joint]) {
        if (locked_freedom(edge) != nullptr && mechanism_.coordinates[c].index == 2) continue;
        for (const auto& [root, ratio] : roots[c].terms)
          if (columns.emplace(root, tree_.columns).second) {
            ++tree_.columns;
            tree_.is_length_column.push_back(mechanism_.coordinates[root].kind == CoordinateKind::length);
          }
      }
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
      if (!in_tree[mechanism_.coordinates[c].joint]) continue;
      if (!columns.contains(roots[c].terms[0].coordinate)) continue;  // a held spin
      LinearQuantityOf<T>& source = tree_.coordinate_expressions[c];
      for (const auto& [root, ratio] : roots[c].terms) source.terms.emplace_back(columns.at(root), ratio);
      source.constant = roots[c].offset;
      source.is_length = mechanism_.coordinates[c].kind == CoordinateKind::length;
    }
  }

  /// The passive freedom of the body that the edge carries, if it has one.
  const PassiveFreedom* locked_freedom(const TreeEdge& edge) const {
    for (const PassiveFreedom& spin : tree_.locked_freedoms)
      if (spin.body == edge.child && (spin.joints[0] == edge.joint || spin.joints[1] == edge.joint)) return &spin;
    return nullptr;
  }

  CoordinateId coordinate_of(JointId joint, int index) const {
    for (const CoordinateId c : coordinates_[joint])
      if (mechanism_.coordinates[c].index == index) return c;
    throw std::invalid_argument("joint has no such coordinate");
  }

  NodeId add_node(NodeId parent, const Matrix3Of<T>& R, const Vector3Of<T>& p, NodeMotion motion) {
    Node<S> node;
    node.parent = parent;
    node.motion = motion;
    node.R_PF = to_rotation<S>(R);
    node.p_PF = to_vector<S>(p);
    tree_.nodes.push_back(node);
    return static_cast<int>(tree_.nodes.size()) - 1;
  }

  /// As many nodes about or along the same axis as the displacement has terms: their sum is the displacement.
  NodeId add_nodes(NodeId parent, const Matrix3Of<T>& R, const Vector3Of<T>& p, NodeMotion motion,
                   const LinearQuantityOf<T>& displacement, const T& factor) {
    NodeId last = parent;
    for (const auto& [column, ratio] : displacement.terms) {
      const bool first = last == parent;
      last = add_node(last, first ? R : Matrix3Of<T>::Identity(), first ? p : Vector3Of<T>::Zero(), motion);
      Node<S>& node = tree_.nodes[last];
      node.column = column;
      node.ratio = factor * ratio;
      if (first) node.offset = factor * displacement.constant;
    }
    return last;
  }

  void add_joint(const TreeEdge& edge) {
    const JointOf<T>& joint = mechanism_.joints[edge.joint];
    std::vector<ElementaryMotion<T>> chain = list_elementary_motions(joint);
    Vector3Of<T> start = joint.point_first, end = joint.point_second;
    Matrix3Of<T> R_parent_child = joint.rotation;
    const Vector3Of<T> up = edge.forward ? joint.axis : Vector3Of<T>(joint.rotation.transpose() * joint.axis);
    if (!edge.forward) {  // walked backwards: the motions in reverse order and sense, seen from the second body
      std::reverse(chain.begin(), chain.end());
      for (ElementaryMotion<T>& step : chain) step.direction = joint.rotation.transpose() * step.direction;
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) chain[k].axial_offset = -chain[k + 1].axial_offset;
      std::swap(start, end);
      R_parent_child = joint.rotation.transpose();
    }
    const PassiveFreedom* spin = locked_freedom(edge);
    if (spin != nullptr) chain = locked_spherical_turns(*spin, R_parent_child);
    const FixedFrame<S> parent = tree_.bodies[edge.parent];
    NodeId node = parent.node;
    Matrix3Of<T> R = to_matrix(parent.R_N);  // axes of the parent body in the current node
    Vector3Of<T> p = R * start + to_3d(parent.p_N);
    const bool sphere = joint.type == JointType::rolling_sphere;
    if ((joint.type == JointType::spherical || sphere) && !needed_[edge.joint]) {
      tree_.spherical_joints.push_back(static_cast<int>(tree_.nodes.size()) + (sphere && edge.forward ? 2 : 0));
      for (const int c : coordinates_[edge.joint])
        tree_.is_floating[c] = !sphere || mechanism_.coordinates[c].index >= 2;
    }
    if (chain.empty()) node = add_node(node, R, p, NodeMotion::weld), R.setIdentity(), p.setZero();
    for (const ElementaryMotion<T>& step : chain) {
      const Matrix3Of<T> axes = node_axes<S>(step);
      const T sign = spin != nullptr || edge.forward ? 1 : -1;
      node = step.motion == NodeMotion::weld
                 ? add_node(node, R * axes, p, step.motion)
                 : add_nodes(node, R * axes, p, step.motion,
                             tree_.coordinate_expressions[coordinate_of(edge.joint, step.index)], sign);
      R = axes.transpose();
      p = step.axial_offset * (R * up);
    }
    tree_.joint_nodes[edge.joint] = node;
    tree_.joint_forward[edge.joint] = edge.forward;
    const Matrix3Of<T> R_NB = R * R_parent_child;
    const FixedFrame<S> child{node, to_rotation<S>(R_NB), to_vector<S>(Vector3Of<T>(p - R_NB * end))};
    if (edge.split)
      add_split(edge.joint, child, edge.child);
    else
      tree_.bodies[edge.child] = child;
  }

  /// Two turns across the line of a passive freedom, and in the place of the third, about the line, a weld.
  std::vector<ElementaryMotion<T>> locked_spherical_turns(const PassiveFreedom& spin,
                                                          const Matrix3Of<T>& R_parent_child) const {
    const Matrix3Of<T> axes = frame_with_z_along(Vector3Of<T>(R_parent_child * line_of(spin)));
    return {{NodeMotion::revolute, axes.col(0), 0},
            {NodeMotion::revolute, axes.col(1), 1},
            {NodeMotion::weld, axes.col(2), 2}};
  }

  /// The line of a passive freedom with its derivatives, if there are any: through a rod's joints, along a leg's slide.
  Vector3Of<T> line_of(const PassiveFreedom& spin) const {
    if constexpr (std::is_same_v<T, double>) {
      return spin.line;
    } else {
      for (const JointOf<T>& slide : mechanism_.joints) {
        if (slide.type != JointType::prismatic) continue;
        if (slide.first == spin.body) return slide.axis;
        if (slide.second == spin.body) return slide.rotation.transpose() * slide.axis;
      }
      const auto place = [&](int j) {
        const JointOf<T>& joint = mechanism_.joints[j];
        return joint.first == spin.body ? joint.point_first : joint.point_second;
      };
      const Vector3Of<T> line = (place(spin.joints[1]) - place(spin.joints[0])).normalized();
      return line.dot(spin.line.cast<T>()) < 0 ? Vector3Of<T>(-line) : line;
    }
  }

  /// Closes the loop of a split joint: the copy that the joint carries is its second body.
  void add_split(JointId joint, const FixedFrame<S>& copy, BodyId body) { splits_.push_back({joint, copy, body}); }

  void add_closure(int j) {
    const JointOf<T>& joint = mechanism_.joints[j];
    const Matrix3Of<T> axes = closure_axes<S>(joint);
    Closure<S> closure;
    closure.joint = j;
    closure.a = offset_frame<S>(tree_.bodies[joint.first], axes, joint.point_first);
    closure.b = offset_frame<S>(tree_.bodies[joint.second], joint.rotation.transpose() * axes, joint.point_second);
    set_closure_rows(joint.type, closure);
    tree_.closures.push_back(closure);
  }

  void add_mass_elements() {
    for (const auto& split : splits_) {
      Closure<S> closure;
      closure.joint = split.joint;
      closure.split = true;
      const Vector3Of<T> at = mechanism_.joints[split.joint].point_second;
      closure.a = offset_frame<S>(split.copy, Matrix3Of<T>::Identity(), at);
      closure.b = offset_frame<S>(tree_.bodies[split.body], Matrix3Of<T>::Identity(), at);
      set_closure_rows(JointType::fixed, closure);
      tree_.closures.push_back(closure);
    }
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) {
      const BodyOf<T>& body = mechanism_.bodies[b];
      add_element(tree_.bodies[b], inertia_about_origin<S>(body.mass, body.com, body.inertia));
    }
    for (const AttachmentOf<T>& extra : mechanism_.attachments)
      add_element(tree_.bodies[extra.body], inertia_about_origin<S>(extra.mass, extra.position, extra.inertia));
    for (const DiscOf<T>& disc : mechanism_.discs) add_disc(disc);
  }

  void add_disc(const DiscOf<T>& disc) {
    const FixedFrame<S>& carrier = tree_.bodies[disc.body];
    const Matrix3Of<T> axes = node_axes<S>({NodeMotion::revolute, disc.axis, 0});
    const Matrix3Of<T> R = to_matrix(carrier.R_N) * axes;
    const Vector3Of<T> p = to_3d(carrier.p_N) + to_matrix(carrier.R_N) * disc.position;
    const NodeId node = add_nodes(carrier.node, R, p, NodeMotion::revolute, combine_followed(disc.follows), disc.ratio);
    // the disc's own frame: its CoM, the carrier's axes at coordinate zero
    const FixedFrame<S> frame{node, to_rotation<S>(Matrix3Of<T>(axes.transpose())), S::Vector::Zero()};
    add_element(frame, inertia_about_origin<S>(disc.mass, Vector3Of<T>::Zero(), disc.inertia));
  }

  /// What a disc follows in terms of the tree's coordinates, of which several followed ones may be multiples.
  LinearQuantityOf<T> combine_followed(const CoordinateCombinationOf<T>& what) const {
    LinearQuantityOf<T> sum;
    std::map<int, std::size_t> places;
    for (const auto& [coordinate, ratio] : what.terms) {
      const LinearQuantityOf<T>& source = tree_.coordinate_expressions[coordinate];
      sum.constant += ratio * source.constant;
      for (const auto& [column, factor] : source.terms) {
        const auto [place, fresh] = places.emplace(column, sum.terms.size());
        if (fresh) sum.terms.emplace_back(column, T(0));
        sum.terms[place->second].second += ratio * factor;
      }
    }
    return sum;
  }

  void add_element(const FixedFrame<S>& frame, const typename S::Inertia& inertia) {
    tree_.mass_elements.push_back({frame, inertia});
    if (frame.node == 0) return;  // fixed to the ground: neither moves nor counts
    const typename S::Inertia in_node = transform_inertia<S>(inertia, frame.R_N, frame.p_N);
    Node<S>& node = tree_.nodes[frame.node];
    tree_.mass += inertia.mass;
    node.inertia.mass += in_node.mass;
    node.inertia.first_moment += in_node.first_moment;
    node.inertia.second_moment += in_node.second_moment;
    node.massless = false;
  }

  void find_path(Closure<S>& closure) {
    for (int b = closure.b.node, a = closure.a.node; a != b;) {  // parents come before their children
      int& last = b > a ? b : a;
      if (tree_.nodes[last].motion != NodeMotion::weld) closure.path.push_back({last, b > a ? 1.0 : -1.0});
      last = tree_.nodes[last].parent;
    }
    std::reverse(closure.path.begin(), closure.path.end());
  }

  struct Split {
    JointId joint;
    FixedFrame<S> copy;
    BodyId body;
  };

  const MechanismOf<T>& mechanism_;
  std::vector<std::vector<CoordinateId>> coordinates_;  ///< per joint
  std::vector<bool> needed_;                            ///< per joint
  SpanningTree spanning_;
  Tree<S> tree_;
  std::vector<Split> splits_;
};

}  // namespace

template <class S>
Tree<S> compile_tree(const MechanismOf<typename S::Scalar>& mechanism, const std::vector<CoordinateId>& needed) {
  return TreeCompiler<S>(mechanism, needed).run();
}

template Tree<PlanarOf<EngineScalar>> compile_tree<PlanarOf<EngineScalar>>(const MechanismOf<EngineScalar>&,
                                                                           const std::vector<CoordinateId>&);
template Tree<SpatialOf<EngineScalar>> compile_tree<SpatialOf<EngineScalar>>(const MechanismOf<EngineScalar>&,
                                                                             const std::vector<CoordinateId>&);
template PlanarOf<EngineScalar>::Inertia inertia_about_origin<PlanarOf<EngineScalar>>(const EngineScalar&,
                                                                                      const Vector3Of<EngineScalar>&,
                                                                                      const Matrix3Of<EngineScalar>&);
template SpatialOf<EngineScalar>::Inertia inertia_about_origin<SpatialOf<EngineScalar>>(const EngineScalar&,
                                                                                        const Vector3Of<EngineScalar>&,
                                                                                        const Matrix3Of<EngineScalar>&);
template PlanarOf<EngineScalar>::Inertia transform_inertia<PlanarOf<EngineScalar>>(
    const PlanarOf<EngineScalar>::Inertia&, const PlanarRotation<EngineScalar>&, const Vector2Of<EngineScalar>&);
template SpatialOf<EngineScalar>::Inertia transform_inertia<SpatialOf<EngineScalar>>(
    const SpatialOf<EngineScalar>::Inertia&, const SpatialRotation<EngineScalar>&, const Vector3Of<EngineScalar>&);

}  // namespace balance
