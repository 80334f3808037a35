#include "balance/kinematics/tree.hpp"

#include "balance/base/rotation.hpp"
#include "balance/kinematics/joint_steps.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace balance {

template <>
Planar::Inertia inertia_about_origin<Planar>(double mass, const Vector3& com, const Matrix3& about_com) {
  return {mass, mass * com.head<2>(), about_com(2, 2) + mass * com.head<2>().squaredNorm()};
}

template <>
Spatial::Inertia inertia_about_origin<Spatial>(double mass, const Vector3& com, const Matrix3& about_com) {
  return {mass, mass * com, about_com + mass * (com.squaredNorm() * Matrix3::Identity() - com * com.transpose())};
}

template <>
Planar::Inertia moved<Planar>(const Planar::Inertia& inertia, const Planar::Rotation& R, const Vector2& p) {
  const Vector2 moment = R * inertia.moment;
  return {inertia.mass, moment + inertia.mass * p, inertia.second + 2 * p.dot(moment) + inertia.mass * p.squaredNorm()};
}

template <>
Spatial::Inertia moved<Spatial>(const Spatial::Inertia& inertia, const Spatial::Rotation& R, const Vector3& p) {
  const Vector3 moment = R * inertia.moment;
  const Matrix3 second = R.matrix * inertia.second * R.matrix.transpose();
  const Matrix3 E = Matrix3::Identity();
  return {inertia.mass, moment + inertia.mass * p,
          second + 2 * p.dot(moment) * E - p * moment.transpose() - moment * p.transpose() +
              inertia.mass * (p.squaredNorm() * E - p * p.transpose())};
}

namespace {

/// q[coordinate] = ratio · q[root] + offset after following the couplings.
struct Root {
  int coordinate;
  double ratio = 1, offset = 0;
};

Root root_of(const Mechanism& mechanism, int coordinate) {
  Root root{coordinate};
  for (std::size_t guard = 0; guard <= mechanism.couplings.size(); ++guard) {
    const auto it = std::find_if(mechanism.couplings.begin(), mechanism.couplings.end(),
                                 [&](const Coupling& c) { return c.follower == root.coordinate; });
    if (it == mechanism.couplings.end()) return root;
    root.offset += root.ratio * it->offset;
    root.ratio *= it->ratio;
    root.coordinate = it->leader;
  }
  throw std::invalid_argument("couplings follow each other in a circle");
}

template <class S>
class Compiler {
 public:
  Compiler(const Mechanism& mechanism, const std::vector<int>& needed)
      : mechanism_(mechanism), needed_(joints_needed(mechanism, needed)), spanning_(span(mechanism, needed)) {
    if (mechanism.space == SpaceKind::spatial) tree_.held_spins = held_spins(mechanism, needed, spanning_);
  }

  Tree<S> run() {
    tree_.length = characteristic_length(mechanism_);
    tree_.nodes.emplace_back();
    tree_.bodies.resize(mechanism_.bodies.size());
    tree_.joint_nodes.assign(mechanism_.joints.size(), -1);
    tree_.joint_forward.assign(mechanism_.joints.size(), true);
    tree_.joint_floats.assign(mechanism_.joints.size(), false);
    number_columns();
    for (const TreeEdge& edge : spanning_.edges) add_joint(edge);
    for (const int joint : spanning_.cut) add_closure(joint);
    add_masses();
    for (Closure<S>& closure : tree_.closures) {
      find_path(closure);
      tree_.closure_rows += static_cast<int>(closure.rows.size());
      closure.pinned = std::count_if(closure.rows.begin(), closure.rows.end(), [](const ClosureRow& row) {
                         return row.kind == ClosureRow::Kind::along;
                       }) == S::dimension;
      tree_.slides = tree_.slides || !closure.pinned;
    }
    return std::move(tree_);
  }

 private:
  void number_columns() {
    std::vector<bool> in_tree(mechanism_.joints.size(), false);
    for (const TreeEdge& edge : spanning_.edges) in_tree[edge.joint] = true;
    std::map<int, int> columns;
    tree_.sources.resize(mechanism_.coordinates.size());
    // columns in the order of the tree keep the loops' blocks together
    for (const TreeEdge& edge : spanning_.edges)
      for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
        if (mechanism_.coordinates[c].joint != edge.joint) continue;
        if (held_spin(edge) != nullptr && mechanism_.coordinates[c].index == 2) continue;
        const int root = root_of(mechanism_, static_cast<int>(c)).coordinate;
        if (columns.emplace(root, tree_.columns).second) {
          ++tree_.columns;
          tree_.column_kind_length.push_back(mechanism_.coordinates[root].kind == CoordinateKind::length);
        }
      }
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
      if (!in_tree[mechanism_.coordinates[c].joint]) continue;
      const Root root = root_of(mechanism_, static_cast<int>(c));
      if (!columns.contains(root.coordinate)) continue;  // a held spin
      tree_.sources[c] = {columns.at(root.coordinate), root.ratio, root.offset};
    }
  }

  /// The idle spin of the body that the edge carries, if it has one.
  const IdleSpin* held_spin(const TreeEdge& edge) const {
    for (const IdleSpin& spin : tree_.held_spins)
      if (spin.body == edge.child && (spin.joints[0] == edge.joint || spin.joints[1] == edge.joint)) return &spin;
    return nullptr;
  }

  int coordinate_of(int joint, int index) const {
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c)
      if (mechanism_.coordinates[c].joint == joint && mechanism_.coordinates[c].index == index)
        return static_cast<int>(c);
    throw std::invalid_argument("joint has no such coordinate");
  }

  int add_node(int parent, const Matrix3& R, const Vector3& p, NodeMotion motion, const CoordinateSource& source,
               double sign) {
    Node<S> node;
    node.parent = parent;
    node.motion = motion;
    node.column = source.column;
    node.ratio = sign * source.ratio;
    node.offset = sign * source.offset;
    node.R_PF = to_rotation<S>(R);
    node.p_PF = to_vector<S>(p);
    tree_.nodes.push_back(node);
    return static_cast<int>(tree_.nodes.size()) - 1;
  }

  void add_joint(const TreeEdge& edge) {
    const Joint& joint = mechanism_.joints[edge.joint];
    std::vector<Step> chain = steps(joint);
    Vector3 start = joint.point_first, end = joint.point_second;
    Matrix3 R_parent_child = joint.rotation;
    if (!edge.forward) {  // walked backwards: the motions in reverse order and sense, seen from the second body
      std::reverse(chain.begin(), chain.end());
      for (Step& step : chain) step.direction = joint.rotation.transpose() * step.direction;
      std::swap(start, end);
      R_parent_child = joint.rotation.transpose();
    }
    const IdleSpin* spin = held_spin(edge);
    if (spin != nullptr) chain = turns_before(*spin, R_parent_child);
    const FixedFrame<S> parent = tree_.bodies[edge.parent];
    int node = parent.node;
    Matrix3 R = to_matrix(parent.R_N);  // axes of the parent body in the current node
    Vector3 p = R * start + to_3d(parent.p_N);
    if (joint.type == JointType::spherical && !needed_[edge.joint]) {
      tree_.balls.push_back(static_cast<int>(tree_.nodes.size()));
      tree_.joint_floats[edge.joint] = true;
    }
    if (chain.empty()) node = add_node(node, R, p, NodeMotion::weld, {}, 1), R.setIdentity(), p.setZero();
    for (const Step& step : chain) {
      const Matrix3 axes = node_axes<S>(step);
      node = add_node(node, R * axes, p, step.motion, source_of(edge.joint, step),
                      spin != nullptr || edge.forward ? 1 : -1);
      R = axes.transpose();
      p.setZero();
    }
    tree_.joint_nodes[edge.joint] = node;
    tree_.joint_forward[edge.joint] = edge.forward;
    const Matrix3 R_NB = R * R_parent_child;
    const FixedFrame<S> child{node, to_rotation<S>(R_NB), to_vector<S>(Vector3(-(R_NB * end)))};
    if (edge.split)
      weld(edge.joint, child, edge.child);
    else
      tree_.bodies[edge.child] = child;
  }

  /// Two turns across the line of an idle spin, and in the place of the third, about the line, a weld.
  static std::vector<Step> turns_before(const IdleSpin& spin, const Matrix3& R_parent_child) {
    const Matrix3 axes = frame_with_z_along(R_parent_child * spin.line);
    return {{NodeMotion::turn, axes.col(0), 0}, {NodeMotion::turn, axes.col(1), 1}, {NodeMotion::weld, axes.col(2), 2}};
  }

  CoordinateSource source_of(int joint, const Step& step) const {
    return step.motion == NodeMotion::weld ? CoordinateSource{} : tree_.sources[coordinate_of(joint, step.index)];
  }

  /// Closes the loop of a split joint: the copy that the joint carries is its second body.
  void weld(int joint, const FixedFrame<S>& copy, int body) { splits_.push_back({joint, copy, body}); }

  static FixedFrame<S> on(const FixedFrame<S>& body, const Matrix3& R, const Vector3& p) {
    return {body.node, body.R_N * to_rotation<S>(R), body.p_N + body.R_N * to_vector<S>(p)};
  }

  void add_closure(int j) {
    const Joint& joint = mechanism_.joints[j];
    const Matrix3 axes = closure_axes<S>(joint);
    Closure<S> closure;
    closure.joint = j;
    closure.a = on(tree_.bodies[joint.first], axes, joint.point_first);
    closure.b = on(tree_.bodies[joint.second], joint.rotation.transpose() * axes, joint.point_second);
    set_rows(joint.type, closure);
    tree_.closures.push_back(closure);
  }

  void add_masses() {
    for (const auto& split : splits_) {
      Closure<S> closure;
      closure.joint = split.joint;
      closure.split = true;
      const Vector3 at = mechanism_.joints[split.joint].point_second;
      closure.a = on(split.copy, Matrix3::Identity(), at);
      closure.b = on(tree_.bodies[split.body], Matrix3::Identity(), at);
      set_rows(JointType::fixed, closure);
      tree_.closures.push_back(closure);
    }
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) {
      const Body& body = mechanism_.bodies[b];
      add_element(tree_.bodies[b], inertia_about_origin<S>(body.mass, body.com, body.inertia));
    }
    for (const Attachment& extra : mechanism_.attachments)
      add_element(tree_.bodies[extra.body], inertia_about_origin<S>(extra.mass, extra.position, extra.inertia));
    for (const Disc& disc : mechanism_.discs) add_disc(disc);
  }

  void add_disc(const Disc& disc) {
    const FixedFrame<S>& carrier = tree_.bodies[disc.body];
    const Matrix3 axes = node_axes<S>({NodeMotion::turn, disc.axis, 0});
    const Matrix3 R = to_matrix(carrier.R_N) * axes;
    const Vector3 p = to_3d(carrier.p_N) + to_matrix(carrier.R_N) * disc.position;
    CoordinateSource source = tree_.sources[disc.follows];
    source.ratio *= disc.ratio;
    source.offset *= disc.ratio;
    const int node = add_node(carrier.node, R, p, NodeMotion::turn, source, 1);
    // the disc's own frame: its CoM, the carrier's axes at coordinate zero
    const FixedFrame<S> frame{node, to_rotation<S>(axes.transpose()), S::Vector::Zero()};
    add_element(frame, inertia_about_origin<S>(disc.mass, Vector3::Zero(), disc.inertia));
  }

  void add_element(const FixedFrame<S>& frame, const typename S::Inertia& inertia) {
    tree_.elements.push_back({frame, inertia});
    if (frame.node == 0) return;  // fixed to the ground: neither moves nor counts
    const typename S::Inertia in_node = moved<S>(inertia, frame.R_N, frame.p_N);
    Node<S>& node = tree_.nodes[frame.node];
    tree_.mass += inertia.mass;
    node.inertia.mass += in_node.mass;
    node.inertia.moment += in_node.moment;
    node.inertia.second += in_node.second;
    node.massless = false;
  }

  void find_path(Closure<S>& closure) {
    std::vector<double> sign(tree_.nodes.size(), 0);
    for (int n = closure.b.node; n > 0; n = tree_.nodes[n].parent) sign[n] += 1;
    for (int n = closure.a.node; n > 0; n = tree_.nodes[n].parent) sign[n] -= 1;
    for (std::size_t n = 0; n < sign.size(); ++n)
      if (sign[n] != 0 && tree_.nodes[n].motion != NodeMotion::weld)
        closure.path.push_back({static_cast<int>(n), sign[n]});
  }

  struct Split {
    int joint;
    FixedFrame<S> copy;
    int body;
  };

  const Mechanism& mechanism_;
  std::vector<bool> needed_;  ///< per joint
  SpanningTree spanning_;
  Tree<S> tree_;
  std::vector<Split> splits_;
};

}  // namespace

template <class S>
Tree<S> compile(const Mechanism& mechanism, const std::vector<int>& needed) {
  return Compiler<S>(mechanism, needed).run();
}

template <class S>
void rereference(Tree<S>& tree, int ball, double* y) {
  Matrix3 all = Matrix3::Identity(), fixed = Matrix3::Identity();
  for (int n = ball; n < ball + 3; ++n) {
    const Node<S>& node = tree.nodes[n];
    const bool turns = node.motion == NodeMotion::turn;  // the last of a held spin does not
    const double x = turns ? node.ratio * y[node.column] + node.offset : 0;
    all *= to_matrix(turned(node.R_PF, std::cos(x), std::sin(x)));
    if (n > ball) fixed *= to_matrix(node.R_PF);
    if (turns) y[node.column] = -node.offset / node.ratio;
  }
  // products of rotations drift; the nearest rotation does not
  const Eigen::Quaterniond exact = Eigen::Quaterniond(Matrix3(all * fixed.transpose())).normalized();
  tree.nodes[ball].R_PF = to_rotation<S>(exact.toRotationMatrix());
}

template void rereference<Planar>(Tree<Planar>&, int, double*);
template void rereference<Spatial>(Tree<Spatial>&, int, double*);
template Tree<Planar> compile<Planar>(const Mechanism&, const std::vector<int>&);
template Tree<Spatial> compile<Spatial>(const Mechanism&, const std::vector<int>&);

}  // namespace balance
