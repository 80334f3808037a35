#include "read_rigid_tree.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/mechanics/model/couplings.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/model/topology.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <utility>

namespace balance::peers {
namespace {

/// Mass, centre of mass and inertia about it, of everything fixed to one body, in that body's axes.
struct MassSum {
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();

  void add(double m, const Vector3& position, const Matrix3& about_com) {
    inertia += about_com;
    if (m == 0) return;
    const Vector3 arm = position - com;
    inertia += mass * m / (mass + m) * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
    com += m / (mass + m) * arm;
    mass += m;
  }
};

/// An inertia with a moment of zero, of a point or a thin rod, becomes one that every library accepts.
Matrix3 make_positive(const Matrix3& inertia) {
  const Matrix3 symmetric = 0.5 * (inertia + inertia.transpose());
  const double smallest = Eigen::SelfAdjointEigenSolver<Matrix3>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return smallest >= negligible_mass ? symmetric : symmetric + (negligible_mass - smallest) * Matrix3::Identity();
}

struct JointMotions {
  std::vector<ElementaryMotion> motions;  ///< axes of the first body
  std::vector<int> coordinates;           ///< of the joint, one per motion
};

JointMotions list_joint_motions(const Joint& joint) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ(), u = joint.axis, v = joint.axis2;
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{{true, u}}, {0}};
    case JointType::prismatic: return {{{false, u}}, {0}};
    case JointType::pin_slot: return {{{false, u}, {true, z}}, {0, 1}};
    case JointType::cylindrical: return {{{false, u}, {true, u}}, {1, 0}};
    case JointType::universal: return {{{true, u}, {true, v}}, {0, 1}};
    case JointType::spherical: return {{{true, x}, {true, y}, {true, z}}, {0, 1, 2}};
    case JointType::planar: return {{{false, v}, {false, u.cross(v)}, {true, u}}, {0, 1, 2}};
    case JointType::rolling_disc:
    case JointType::rolling_sphere: break;
  }
  throw NotComparable("joint '" + joint.name + "' rolls");
}

/// Axes of a cut joint in the first body at zero coordinates, and its equations.
void describe_cut_joint(const Joint& joint, bool is_planar, Matrix3& axes, std::vector<ClosureEquation>& equations) {
  const ClosureEquation x{true, 0}, y{true, 1}, z{true, 2};
  const ClosureEquation xy{false, 0, 1}, xz{false, 0, 2}, yz{false, 1, 2}, zx{false, 2, 0};
  const Vector3& u = joint.axis;
  axes.setIdentity();
  if (is_planar) {
    if (joint.type == JointType::prismatic || joint.type == JointType::pin_slot)
      axes << u, Vector3::UnitZ().cross(u), Vector3::UnitZ();
    switch (joint.type) {
      case JointType::revolute: equations = {x, y}; return;
      case JointType::prismatic: equations = {y, xy}; return;
      case JointType::pin_slot: equations = {y}; return;
      case JointType::fixed: equations = {x, y, xy}; return;
      case JointType::planar: equations = {}; return;
      default: break;
    }
  } else {
    if (joint.type == JointType::universal || joint.type == JointType::planar)
      axes << joint.axis2, u.cross(joint.axis2), u;
    else if (joint.type != JointType::spherical && joint.type != JointType::fixed)
      axes = frame_with_z_along(u);
    switch (joint.type) {
      case JointType::revolute: equations = {x, y, z, xz, yz}; return;
      case JointType::prismatic: equations = {x, y, xz, yz, xy}; return;
      case JointType::fixed: equations = {x, y, z, xz, yz, xy}; return;
      case JointType::cylindrical: equations = {x, y, xz, yz}; return;
      case JointType::universal: equations = {x, y, z, zx}; return;
      case JointType::spherical: equations = {x, y, z}; return;
      case JointType::planar: equations = {z, xz, yz}; return;
      default: break;
    }
  }
  throw NotComparable("joint '" + joint.name + "' of type " + name_of(joint.type) + " closes a loop");
}

/// Says what of the mechanism the other libraries are not asked about.
void require_comparable(const Mechanism& mechanism, const model::SpanningTree& spanning) {
  if (!mechanism.springs.empty()) throw NotComparable("has springs");
  if (!mechanism.loads.empty()) throw NotComparable("has loads");
  if (!mechanism.friction.empty()) throw NotComparable("has friction");
  if (has_velocity_constraints(mechanism)) throw NotComparable("has constraints on rates");
  if (!model::locked_freedoms(mechanism, {}, spanning).empty())
    throw NotComparable("has bodies that spin idly, whose motion is not unique");
  if (has_temporary_payloads(mechanism)) throw NotComparable("has payloads that come and go");
}

class TreeReader {
 public:
  explicit TreeReader(const Mechanism& mechanism)
      : mechanism_(mechanism),
        spanning_(model::build_spanning_tree(mechanism, {})),
        frames_(mechanism.bodies.size()),
        tree_bodies_(mechanism.bodies.size(), tree_ground),
        masses_(mechanism.bodies.size()),
        shares_(mechanism.bodies.size(), 1),
        joint_coordinates_(coordinates_of_joints(mechanism)) {
    require_comparable(mechanism, spanning_);
    tree_.is_planar = mechanism.space == SpaceKind::planar;
    tree_.gravity = mechanism.gravity;
    for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
      const Body& body = mechanism.bodies[b];
      masses_[b].add(body.mass, body.com, body.inertia);
    }
    for (const Attachment& a : mechanism.attachments) masses_[a.body].add(a.mass, a.position, a.inertia);
    for (const model::TreeEdge& edge : spanning_.edges)
      if (edge.split) shares_[edge.child] += 1;
  }

  RigidTree read() {
    add_discs(model::ground);
    add_children(model::ground);
    for (const Copy& copy : copies_) add_weld(copy);
    for (const JointId j : spanning_.cut) add_cut_joint(mechanism_.joints[j]);
    set_coordinates();
    return std::move(tree_);
  }

 private:
  /// Pose of a body of the mechanism at zero coordinates, and the origin of the tree's body.
  struct ZeroPose {
    Matrix3 rotation = Matrix3::Identity();
    Vector3 origin = Vector3::Zero(), tree_origin = Vector3::Zero();
  };

  /// A further copy of a body, which carries its share of the mass: some libraries refuse a massless one.
  struct Copy {
    JointId joint = 0;
    int tree_body = tree_ground;
    ZeroPose pose;
  };

  static BodyFrame make_frame(int tree_body, const ZeroPose& pose, const Vector3& point, const Matrix3& axes) {
    return {tree_body, pose.origin + pose.rotation * point - pose.tree_origin, pose.rotation * axes};
  }

  Vector3 world_point(BodyId body, const Vector3& point) const {
    return frames_[body].origin + frames_[body].rotation * point;
  }

  int add_body(int parent, const Vector3& parent_origin, const Vector3& origin, const ZeroPose& pose,
               const MassSum& mass, double share) {
    TreeBody body;
    body.parent = parent;
    body.position = origin - parent_origin;
    body.mass = std::max(mass.mass / share, negligible_mass);
    body.com = pose.origin + pose.rotation * mass.com - origin;
    Matrix3 inertia = mass.inertia;
    if (tree_.is_planar) inertia = inertia(2, 2) * Matrix3::Identity();  // only zz matters: a sphere's is one of a body
    body.inertia = make_positive(pose.rotation * inertia * pose.rotation.transpose() / share);
    tree_.bodies.push_back(body);
    return static_cast<int>(tree_.bodies.size()) - 1;
  }

  void add_motion(int body, const ElementaryMotion& motion, const model::CoordinateCombination& displacement,
                  double ratio) {
    tree_.bodies[body].motions.push_back(motion);
    VectorX row = VectorX::Zero(static_cast<Eigen::Index>(mechanism_.coordinates.size()));
    for (const model::CoordinateTerm& term : displacement.terms) row[term.coordinate] += ratio * term.ratio;
    rows_.push_back(row);
  }

  /// Motions of the child of an edge, at the child's pose or that of its copy.
  void add_joint_motions(int body, const model::TreeEdge& edge, const Matrix3& first_rotation) {
    const JointMotions joint = list_joint_motions(mechanism_.joints[edge.joint]);
    const std::size_t count = joint.motions.size();
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t at = edge.forward ? k : count - 1 - k;  // seen from the second body, the last comes first
      ElementaryMotion motion = joint.motions[at];
      motion.axis = (edge.forward ? 1 : -1) * (first_rotation * motion.axis);
      add_motion(body, motion, joint_coordinates_[edge.joint][joint.coordinates[at]], 1);
      tree_coordinates_.push_back(joint_coordinates_[edge.joint][joint.coordinates[at]]);
    }
  }

  void add_edge(const model::TreeEdge& edge) {
    const Joint& joint = mechanism_.joints[edge.joint];
    const ZeroPose& parent = frames_[edge.parent];
    ZeroPose child;
    const Vector3 joint_point = world_point(edge.parent, edge.forward ? joint.point_first : joint.point_second);
    child.rotation = parent.rotation * (edge.forward ? joint.rotation : joint.rotation.transpose());
    child.origin = joint_point - child.rotation * (edge.forward ? joint.point_second : joint.point_first);
    child.tree_origin = joint_point;
    const int body = add_body(tree_bodies_[edge.parent], parent.tree_origin, joint_point, child, masses_[edge.child],
                              shares_[edge.child]);
    add_joint_motions(body, edge, edge.forward ? parent.rotation : child.rotation);
    if (edge.split) {
      copies_.push_back({edge.joint, body, child});
      return;
    }
    frames_[edge.child] = child;
    tree_bodies_[edge.child] = body;
    add_discs(edge.child);
    add_children(edge.child);
  }

  void add_discs(BodyId carrier) {
    for (const Disc& disc : mechanism_.discs) {
      if (!(disc.body == carrier)) continue;
      ZeroPose pose;
      pose.rotation = frames_[carrier].rotation;
      pose.origin = world_point(carrier, disc.position);
      MassSum mass;
      mass.add(disc.mass, Vector3::Zero(), disc.inertia);
      const int body = add_body(tree_bodies_[carrier], frames_[carrier].tree_origin, pose.origin, pose, mass, 1);
      add_motion(body, {true, pose.rotation * disc.axis}, disc.follows, disc.ratio);
    }
  }

  void add_children(BodyId parent) {
    for (const model::TreeEdge& edge : spanning_.edges)
      if (edge.parent == parent) add_edge(edge);
  }

  void add_cut_joint(const Joint& joint) {
    CutJoint cut;
    cut.name = joint.name;
    Matrix3 axes;
    describe_cut_joint(joint, tree_.is_planar, axes, cut.equations);
    cut.a = make_frame(tree_bodies_[joint.first], frames_[joint.first], joint.point_first, axes);
    cut.b = make_frame(tree_bodies_[joint.second], frames_[joint.second], joint.point_second,
                       joint.rotation.transpose() * axes);
    tree_.cut_joints.push_back(cut);
  }

  void add_weld(const Copy& copy) {
    Joint weld = mechanism_.joints[copy.joint];
    weld.type = JointType::fixed;
    CutJoint cut;
    cut.name = weld.name;
    Matrix3 axes;
    describe_cut_joint(weld, tree_.is_planar, axes, cut.equations);
    cut.a = make_frame(copy.tree_body, copy.pose, weld.point_second, axes);
    cut.b = make_frame(tree_bodies_[weld.second], frames_[weld.second], weld.point_second, axes);
    tree_.cut_joints.push_back(cut);
  }

  void set_coordinates() {
    const std::vector<model::ResolvedCouplingOf<double>> roots = resolve_couplings(mechanism_);
    const auto coordinates = static_cast<Eigen::Index>(mechanism_.coordinates.size());
    std::vector<Eigen::Index> columns(mechanism_.coordinates.size(), -1);
    Eigen::Index independent = 0;
    for (const CoordinateId c : tree_coordinates_)
      if (roots[c].terms.size() == 1 && roots[c].terms[0].coordinate == c) columns[c] = independent++;
    MatrixX of_independent = MatrixX::Zero(coordinates, independent);
    for (Eigen::Index c = 0; c < coordinates; ++c)
      for (const model::CoordinateTerm& term : roots[c].terms)
        if (columns[term.coordinate] >= 0) of_independent(c, columns[term.coordinate]) += term.ratio;
    tree_.motions_of_coordinates.resize(static_cast<Eigen::Index>(rows_.size()), coordinates);
    for (std::size_t k = 0; k < rows_.size(); ++k) tree_.motions_of_coordinates.row(k) = rows_[k];
    tree_.motions_of_independent = tree_.motions_of_coordinates * of_independent;
    tree_.efforts_on_independent.resize(independent, static_cast<Eigen::Index>(mechanism_.actuators.size()));
    for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a)
      tree_.efforts_on_independent.col(a) = of_independent.row(mechanism_.actuators[a]);
  }

  const Mechanism& mechanism_;
  model::SpanningTree spanning_;
  std::vector<ZeroPose> frames_;
  std::vector<int> tree_bodies_;
  std::vector<MassSum> masses_;
  std::vector<double> shares_;
  std::vector<std::vector<CoordinateId>> joint_coordinates_;
  std::vector<VectorX> rows_;
  std::vector<CoordinateId> tree_coordinates_;
  std::vector<Copy> copies_;
  RigidTree tree_;
};

}  // namespace

RigidTree read_rigid_tree(const Mechanism& mechanism) { return TreeReader(mechanism).read(); }

}  // namespace balance::peers
