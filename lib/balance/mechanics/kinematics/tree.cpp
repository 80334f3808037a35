#include "balance/mechanics/kinematics/tree.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/model/couplings.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace balance::kinematics {

using model::JointOf;

// Decomposition of joints: the elementary motions of a tree joint, and the equations that enforce a cut joint.

/// One elementary motion of a joint: about or along `direction`, in the first body's axes at coordinate zero.
template <class T>
struct ElementaryMotion {
  NodeMotion motion;
  Vector3Of<T> direction;
  int index;           ///< coordinate within the joint
  T axial_offset = 0;  ///< of the next motion, along the joint's axis [m]
};

/// In order from the first body to the second.
template <class T>
std::vector<ElementaryMotion<T>> list_elementary_motions(const JointOf<T>& joint);

/// Axes in which a node rotates about z or slides along its space's slide direction.
namespace {

/// Number of a joint's coordinates before the three angles of a ball; none if it has no ball.
std::optional<int> count_slides_before_ball(JointType type) {
  switch (type) {
    case JointType::spherical: return 0;
    case JointType::rolling_sphere: return 2;
    case JointType::free: return 3;
    default: return std::nullopt;
  }
}

}  // namespace

template <class S>
Matrix3Of<typename S::Scalar> node_axes(const ElementaryMotion<typename S::Scalar>& step);

/// The axes in which the constraints of a cut joint are simple: z (planar: x) along the joint's axis; universal: x
/// along the second axis.
template <class S>
Matrix3Of<typename S::Scalar> closure_axes(const JointOf<typename S::Scalar>& joint);

/// Sets the rows of a closure to those of a cut joint of this type.
template <class S>
void set_closure_rows(JointType type, Closure<S>& closure);

// Velocity-level closures: rolling contacts and constraints on speeds.

/// A frame fixed to the same node as another frame.
/// @param R, p in that frame's axes, from its origin
template <class S>
FixedFrame<S> offset_frame(const FixedFrame<S>& body, const Matrix3Of<typename S::Scalar>& R,
                           const Vector3Of<typename S::Scalar>& p) {
  return {body.node, body.R_N * to_rotation<S>(R), body.p_N + body.R_N * to_vector<S>(p)};
}

/// The no-slip closure of a rolling joint at its contact point. Its path is determined later.
/// @param j the joint's index
template <class S>
Closure<S> make_rolling_closure(const Tree<S>& tree, const JointOf<typename S::Scalar>& joint, int j);

/// The closure that keeps a sum of speeds at its value, with its path.
template <class S>
Closure<S> make_speed_closure(const Tree<S>& tree, const model::GeneralisedSpeedOf<typename S::Scalar>& constraint);

template <class T>
std::vector<ElementaryMotion<T>> list_elementary_motions(const JointOf<T>& joint) {
  using enum NodeMotion;
  using Vector = Vector3Of<T>;
  const Vector u = joint.axis, v = joint.axis2, z = Vector::UnitZ();
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{revolute, u, 0}};
    case JointType::prismatic: return {{prismatic, u, 0}};
    case JointType::pin_slot: return {{prismatic, u, 0}, {revolute, z, 1}};
    case JointType::cylindrical: return {{prismatic, u, 1}, {revolute, u, 0}};
    case JointType::universal: return {{revolute, u, 0}, {revolute, v, 1}};
    case JointType::spherical:
      return {{revolute, Vector::UnitX(), 0}, {revolute, Vector::UnitY(), 1}, {revolute, z, 2}};
    case JointType::planar: return {{prismatic, v, 0}, {prismatic, cross(u, v), 1}, {revolute, u, 2}};
    case JointType::free:
      return {{prismatic, Vector::UnitX(), 0}, {prismatic, Vector::UnitY(), 1}, {prismatic, z, 2},
              {revolute, Vector::UnitX(), 3},  {revolute, Vector::UnitY(), 4},  {revolute, z, 5}};
    case JointType::rolling_disc:
      return {{prismatic, v, 0},
              {prismatic, cross(u, v), 1},
              {revolute, u, 2},
              {revolute, v, 3, joint.radius},
              {revolute, cross(u, v), 4}};
    case JointType::rolling_sphere:
      return {{prismatic, v, 0},
              {prismatic, cross(u, v), 1, joint.radius},
              {revolute, Vector::UnitX(), 2},
              {revolute, Vector::UnitY(), 3},
              {revolute, z, 4}};
  }
  return {};
}

template <class S>
Matrix3Of<typename S::Scalar> node_axes(const ElementaryMotion<typename S::Scalar>& step) {
  using Matrix = Matrix3Of<typename S::Scalar>;
  if constexpr (is_planar<S>) {
    Matrix R = Matrix::Identity();
    if (step.motion == NodeMotion::revolute) return R;
    const auto& d = step.direction;
    R.template topLeftCorner<2, 2>() << d.x(), -d.y(), d.y(), d.x();
    return R;
  } else {
    return frame_with_z_along(step.direction);
  }
}

template <class S>
Matrix3Of<typename S::Scalar> closure_axes(const JointOf<typename S::Scalar>& joint) {
  using Matrix = Matrix3Of<typename S::Scalar>;
  if constexpr (is_planar<S>) {
    const bool is_sliding = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
    return is_sliding ? node_axes<S>({NodeMotion::prismatic, joint.axis, 0}) : Matrix(Matrix::Identity());
  } else {
    if (joint.type == JointType::spherical || joint.type == JointType::fixed || joint.type == JointType::free)
      return Matrix::Identity();
    if (joint.type != JointType::universal && joint.type != JointType::planar && !is_rolling(joint.type))
      return frame_with_z_along(joint.axis);
    Matrix R;
    R << joint.axis2, cross(joint.axis, joint.axis2), joint.axis;
    return R;
  }
}

template <class S>
void set_closure_rows(JointType type, Closure<S>& closure) {
  using enum ClosureRow::Kind;
  const ClosureRow x{along, 0, 0}, y{along, 1, 0}, z{along, 2, 0};
  if constexpr (is_planar<S>) {
    const ClosureRow angle{dot, 1, 0};
    switch (type) {
      case JointType::revolute: closure.rows = {x, y}; break;
      case JointType::prismatic: closure.rows = {y, angle}, closure.aligned = {0}; break;
      case JointType::pin_slot: closure.rows = {y}; break;
      case JointType::planar: break;  // lets everything move
      case JointType::fixed: closure.rows = {x, y, angle}, closure.aligned = {0}; break;
      default: throw std::invalid_argument("joint type does not exist in the plane");
    }
  } else {
    const ClosureRow xz{dot, 0, 2}, yz{dot, 1, 2}, zx{dot, 2, 0}, xy{dot, 0, 1};
    switch (type) {
      case JointType::revolute: closure.rows = {x, y, z, xz, yz}, closure.aligned = {2}; break;
      case JointType::prismatic: closure.rows = {x, y, yz, zx, xy}, closure.aligned = {0, 2}; break;
      case JointType::fixed: closure.rows = {x, y, z, yz, zx, xy}, closure.aligned = {0, 2}; break;
      case JointType::cylindrical: closure.rows = {x, y, xz, yz}, closure.aligned = {2}; break;
      case JointType::universal: closure.rows = {x, y, z, zx}; break;
      case JointType::spherical: closure.rows = {x, y, z}; break;
      case JointType::planar: closure.rows = {z, xz, yz}, closure.aligned = {2}; break;
      case JointType::free: break;  // lets everything move
      default: throw std::invalid_argument("joint type does not exist in space");
    }
  }
}

template std::vector<ElementaryMotion<EngineScalar>> list_elementary_motions<EngineScalar>(
    const JointOf<EngineScalar>&);
template Matrix3Of<EngineScalar> node_axes<PlanarOf<EngineScalar>>(const ElementaryMotion<EngineScalar>&);
template Matrix3Of<EngineScalar> node_axes<SpatialOf<EngineScalar>>(const ElementaryMotion<EngineScalar>&);
template Matrix3Of<EngineScalar> closure_axes<PlanarOf<EngineScalar>>(const JointOf<EngineScalar>&);
template Matrix3Of<EngineScalar> closure_axes<SpatialOf<EngineScalar>>(const JointOf<EngineScalar>&);
template void set_closure_rows<PlanarOf<EngineScalar>>(JointType, Closure<PlanarOf<EngineScalar>>&);
template void set_closure_rows<SpatialOf<EngineScalar>>(JointType, Closure<SpatialOf<EngineScalar>>&);

namespace {

template <class S>
void grow_row_scale(const typename S::Scalar& factor, double size, Closure<S>& closure) {
  const double magnitude = std::abs(value_of(factor)) * size;
  closure.row_scale = closure.terms.size() == 1 ? magnitude : std::max(closure.row_scale, magnitude);
}

/// Adds one term per column that the coordinate depends on.
template <class S>
void add_coordinate_rate(const Tree<S>& tree, const model::GeneralisedSpeedTermOf<typename S::Scalar>& term,
                         Closure<S>& closure) {
  for (const auto& [column, ratio] : tree.coordinate_expressions[term.index].terms) {
    std::size_t node = 1;
    while (tree.nodes[node].column != column) ++node;
    closure.path.push_back({static_cast<int>(node), 1, static_cast<int>(closure.terms.size())});
    VelocityTerm<S> rate;
    rate.factor = term.factor * ratio;
    closure.terms.push_back(rate);
    grow_row_scale(rate.factor, tree.is_length_column[column] ? tree.characteristic_length : 1, closure);
  }
}

template <class S>
void add_frame_component(const Tree<S>& tree, const model::GeneralisedSpeedTermOf<typename S::Scalar>& term,
                         Closure<S>& closure) {
  using Of = typename model::GeneralisedSpeedTermOf<typename S::Scalar>::Kind;
  const bool velocity = term.kind == Of::velocity || term.kind == Of::velocity_body;
  VelocityTerm<S> rate;
  rate.of = velocity ? VelocityTerm<S>::Of::velocity : VelocityTerm<S>::Of::angular_velocity;
  rate.is_in_body_axes = term.kind == Of::velocity_body || term.kind == Of::angular_velocity_body;
  rate.axis = term.index;
  rate.factor = term.factor;
  rate.frame = offset_frame<S>(tree.bodies[term.body], Matrix3Of<typename S::Scalar>::Identity(), term.position);
  for (int n = rate.frame.node; n > 0; n = tree.nodes[n].parent)
    if (tree.nodes[n].motion != NodeMotion::weld)
      closure.path.push_back({n, 1, static_cast<int>(closure.terms.size())});
  closure.terms.push_back(rate);
  grow_row_scale(rate.factor, velocity ? tree.characteristic_length : 1, closure);
}

}  // namespace

template <class S>
Closure<S> make_rolling_closure(const Tree<S>& tree, const JointOf<typename S::Scalar>& joint, int j) {
  const Matrix3Of<typename S::Scalar> axes = closure_axes<S>(joint);
  Closure<S> closure;
  closure.joint = j;
  closure.a = offset_frame<S>(tree.bodies[joint.first], axes, joint.point_first);
  closure.b = offset_frame<S>(tree.bodies[joint.second], joint.rotation.transpose() * axes, joint.point_second);
  closure.rows = {{ClosureRow::Kind::slip, 0, 0}, {ClosureRow::Kind::slip, 1, 0}};
  closure.contact = {joint.type == JointType::rolling_disc, joint.radius};
  return closure;
}

template <class S>
Closure<S> make_speed_closure(const Tree<S>& tree, const model::GeneralisedSpeedOf<typename S::Scalar>& constraint) {
  Closure<S> closure;
  closure.joint = -1;
  closure.rows = {{ClosureRow::Kind::sum, 0, 0}};
  closure.value =
      constraint.value.template convert<double>([](const typename S::Scalar& number) { return value_of(number); });
  for (const auto& term : constraint.terms)
    if (term.kind == model::GeneralisedSpeedTermOf<typename S::Scalar>::Kind::coordinate)
      add_coordinate_rate(tree, term, closure);
    else
      add_frame_component(tree, term, closure);
  return closure;
}

using OnPlane = PlanarOf<EngineScalar>;
using InSpace = SpatialOf<EngineScalar>;
template Closure<OnPlane> make_rolling_closure<OnPlane>(const Tree<OnPlane>&, const JointOf<EngineScalar>&, int);
template Closure<InSpace> make_rolling_closure<InSpace>(const Tree<InSpace>&, const JointOf<EngineScalar>&, int);
template Closure<OnPlane> make_speed_closure<OnPlane>(const Tree<OnPlane>&,
                                                      const model::GeneralisedSpeedOf<EngineScalar>&);
template Closure<InSpace> make_speed_closure<InSpace>(const Tree<InSpace>&,
                                                      const model::GeneralisedSpeedOf<EngineScalar>&);

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
    for (const model::TreeEdge& edge : spanning_.edges) add_joint(edge);
    for (const JointId joint : spanning_.cut) add_closure(joint);
    add_mass_elements();
    for (const model::TreeEdge& edge : spanning_.edges)
      if (const JointOf<T>& joint = mechanism_.joints[edge.joint]; is_rolling(joint.type) && !joint.slips)
        tree_.closures.push_back(make_rolling_closure(tree_, joint, edge.joint));
    for (const model::GeneralisedSpeedOf<T>& constraint : mechanism_.constraints)
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
    for (const model::TreeEdge& edge : spanning_.edges) in_tree[edge.joint] = true;
    std::map<int, int> columns;
    const std::vector<model::ResolvedCouplingOf<T>> roots = resolve_couplings(mechanism_);
    tree_.coordinate_expressions.resize(mechanism_.coordinates.size());
    // numbering columns in tree order keeps the blocks of the loops together
    for (const model::TreeEdge& edge : spanning_.edges)
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
      if (!columns.contains(roots[c].terms[0].coordinate)) continue;  // a locked passive freedom
      LinearQuantityOf<T>& source = tree_.coordinate_expressions[c];
      for (const auto& [root, ratio] : roots[c].terms) source.terms.emplace_back(columns.at(root), ratio);
      source.constant = roots[c].offset;
      source.is_length = mechanism_.coordinates[c].kind == CoordinateKind::length;
    }
  }

  /// The passive freedom of the body that the edge carries, if it has one.
  const model::PassiveFreedom* locked_freedom(const model::TreeEdge& edge) const {
    for (const model::PassiveFreedom& freedom : tree_.locked_freedoms)
      if (freedom.body == edge.child && (freedom.joints[0] == edge.joint || freedom.joints[1] == edge.joint))
        return &freedom;
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

  /// Adds one node per term of the displacement, all about or along the same axis, so that they sum to it.
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

  void add_joint(const model::TreeEdge& edge) {
    const JointOf<T>& joint = mechanism_.joints[edge.joint];
    std::vector<ElementaryMotion<T>> motions = list_elementary_motions(joint);
    Vector3Of<T> start = joint.point_first, end = joint.point_second;
    Matrix3Of<T> R_parent_child = joint.rotation;
    const Vector3Of<T> joint_axis = edge.forward ? joint.axis : Vector3Of<T>(joint.rotation.transpose() * joint.axis);
    if (!edge.forward) {  // traversed backwards: the motions in reverse order and sense, seen from the second body
      std::reverse(motions.begin(), motions.end());
      for (ElementaryMotion<T>& step : motions) step.direction = joint.rotation.transpose() * step.direction;
      for (std::size_t k = 0; k + 1 < motions.size(); ++k) motions[k].axial_offset = -motions[k + 1].axial_offset;
      std::swap(start, end);
      R_parent_child = joint.rotation.transpose();
    }
    const model::PassiveFreedom* freedom = locked_freedom(edge);
    if (freedom != nullptr) motions = locked_spherical_motions(*freedom, R_parent_child);
    const FixedFrame<S> parent = tree_.bodies[edge.parent];
    NodeId node = parent.node;
    Matrix3Of<T> R = to_matrix(parent.R_N);  // axes of the parent body in the current node
    Vector3Of<T> p = R * start + to_3d(parent.p_N);
    if (const std::optional<int> slides = count_slides_before_ball(joint.type); slides && !needed_[edge.joint]) {
      tree_.spherical_joints.push_back(static_cast<int>(tree_.nodes.size()) + (edge.forward ? *slides : 0));
      for (const int c : coordinates_[edge.joint]) tree_.is_floating[c] = mechanism_.coordinates[c].index >= *slides;
    }
    if (motions.empty()) node = add_node(node, R, p, NodeMotion::weld), R.setIdentity(), p.setZero();
    for (const ElementaryMotion<T>& step : motions) {
      const Matrix3Of<T> axes = node_axes<S>(step);
      const T sign = freedom != nullptr || edge.forward ? 1 : -1;
      node = step.motion == NodeMotion::weld
                 ? add_node(node, R * axes, p, step.motion)
                 : add_nodes(node, R * axes, p, step.motion,
                             tree_.coordinate_expressions[coordinate_of(edge.joint, step.index)], sign);
      R = axes.transpose();
      p = step.axial_offset * (R * joint_axis);
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

  /// Two rotations perpendicular to the line of a passive freedom; a weld replaces the third one, about the line.
  std::vector<ElementaryMotion<T>> locked_spherical_motions(const model::PassiveFreedom& freedom,
                                                            const Matrix3Of<T>& R_parent_child) const {
    const Matrix3Of<T> axes = frame_with_z_along(Vector3Of<T>(R_parent_child * line_of(freedom)));
    return {{NodeMotion::revolute, axes.col(0), 0},
            {NodeMotion::revolute, axes.col(1), 1},
            {NodeMotion::weld, axes.col(2), 2}};
  }

  /// The line of a passive freedom, with derivatives if T has them: through a rod's joints, or along a leg's slide.
  Vector3Of<T> line_of(const model::PassiveFreedom& freedom) const {
    if constexpr (std::is_same_v<T, double>) {
      return freedom.line;
    } else {
      for (const JointOf<T>& slide : mechanism_.joints) {
        if (slide.type != JointType::prismatic) continue;
        if (slide.first == freedom.body) return slide.axis;
        if (slide.second == freedom.body) return slide.rotation.transpose() * slide.axis;
      }
      const auto joint_point = [&](int j) {
        const JointOf<T>& joint = mechanism_.joints[j];
        return joint.first == freedom.body ? joint.point_first : joint.point_second;
      };
      const Vector3Of<T> line = (joint_point(freedom.joints[1]) - joint_point(freedom.joints[0])).normalized();
      return line.dot(freedom.line.cast<T>()) < 0 ? Vector3Of<T>(-line) : line;
    }
  }

  /// Records a split joint, whose loop is closed by welding the copy that it carries to its second body.
  void add_split(JointId joint, const FixedFrame<S>& copy, BodyId body) { splits_.push_back({joint, copy, body}); }

  void add_closure(int j) {
    const JointOf<T>& joint = mechanism_.joints[j];
    const Matrix3Of<T> axes = closure_axes<S>(joint);
    Closure<S> closure;
    closure.joint = j;
    closure.a = offset_frame<S>(tree_.bodies[joint.first], axes, joint.point_first);
    closure.b = offset_frame<S>(tree_.bodies[joint.second], joint.rotation.transpose() * axes, joint.point_second);
    set_closure_rows(joint.type, closure);
    if (!closure.rows.empty()) tree_.closures.push_back(closure);
  }

  void add_mass_elements() {
    for (const auto& split : splits_) {
      Closure<S> closure;
      closure.joint = split.joint;
      closure.split = true;
      const Vector3Of<T> point = mechanism_.joints[split.joint].point_second;
      closure.a = offset_frame<S>(split.copy, Matrix3Of<T>::Identity(), point);
      closure.b = offset_frame<S>(tree_.bodies[split.body], Matrix3Of<T>::Identity(), point);
      set_closure_rows(JointType::fixed, closure);
      tree_.closures.push_back(closure);
    }
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) {
      const model::BodyOf<T>& body = mechanism_.bodies[b];
      add_element(tree_.bodies[b], inertia_about_origin<S>(body.mass, body.com, body.inertia));
    }
    for (const model::AttachmentOf<T>& attachment : mechanism_.attachments)
      add_element(tree_.bodies[attachment.body],
                  inertia_about_origin<S>(attachment.mass, attachment.position, attachment.inertia));
    for (const model::DiscOf<T>& disc : mechanism_.discs) add_disc(disc);
  }

  void add_disc(const model::DiscOf<T>& disc) {
    const FixedFrame<S>& carrier = tree_.bodies[disc.body];
    const Matrix3Of<T> axes = node_axes<S>({NodeMotion::revolute, disc.axis, 0});
    const Matrix3Of<T> R = to_matrix(carrier.R_N) * axes;
    const Vector3Of<T> p = to_3d(carrier.p_N) + to_matrix(carrier.R_N) * disc.position;
    const NodeId node = add_nodes(carrier.node, R, p, NodeMotion::revolute, combine_followed(disc.follows), disc.ratio);
    // the disc's own frame: its CoM, the carrier's axes at coordinate zero
    const FixedFrame<S> frame{node, to_rotation<S>(Matrix3Of<T>(axes.transpose())), S::Vector::Zero()};
    add_element(frame, inertia_about_origin<S>(disc.mass, Vector3Of<T>::Zero(), disc.inertia));
  }

  /// The combination that a disc follows, in the tree's coordinates. Several followed coordinates may share a column.
  LinearQuantityOf<T> combine_followed(const model::CoordinateCombinationOf<T>& combination) const {
    LinearQuantityOf<T> sum;
    std::map<int, std::size_t> term_indices;
    for (const auto& [coordinate, ratio] : combination.terms) {
      const LinearQuantityOf<T>& source = tree_.coordinate_expressions[coordinate];
      sum.constant += ratio * source.constant;
      for (const auto& [column, factor] : source.terms) {
        const auto [entry, is_new] = term_indices.emplace(column, sum.terms.size());
        if (is_new) sum.terms.emplace_back(column, T(0));
        sum.terms[entry->second].second += ratio * factor;
      }
    }
    return sum;
  }

  void add_element(const FixedFrame<S>& frame, const typename S::Inertia& inertia) {
    tree_.mass_elements.push_back({frame, inertia});
    if (frame.node == 0) return;  // fixed to the ground: does not contribute
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
  model::SpanningTree spanning_;
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

}  // namespace balance::kinematics
