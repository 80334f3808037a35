#pragma once
/// A mechanism compiled for the recursions: every joint of the spanning tree becomes a chain of nodes, each of which
/// rotates about or slides along an axis of its own frame; loop joints become closures.

#include "balance/foundation/base/id.hpp"
#include "balance/mechanics/kinematics/space.hpp"
#include "balance/mechanics/model/topology.hpp"

#include <utility>
#include <vector>

namespace balance::kinematics {

// Quantities that are linear in the tree's coordinates: joint coordinates, the angle of a planar tool.

using ColumnId = TypedIndex<struct ColumnList>;  ///< index into the tree's coordinates y and matrix columns

/// Σ coefficient · y[column] + constant.
template <class T>
struct LinearQuantityOf {
  std::vector<std::pair<ColumnId, T>> terms;
  T constant = 0;
  bool is_length = false;

  /// @tparam N T, or a pack of several samples
  template <class N>
  N value(const N* y) const {
    return constant + rate(y);
  }
  /// Rate of the value for the coordinates' rates dy; likewise its acceleration for their accelerations.
  template <class N>
  N rate(const N* dy) const {
    N sum = 0;
    for (const auto& [column, coefficient] : terms) sum += coefficient * dy[column];
    return sum;
  }
  /// Adds the generalised forces of an effort conjugate to the quantity, which have the same power.
  void add_generalised_force(const T& effort, T* tau) const {
    for (const auto& [column, coefficient] : terms) tau[column] += coefficient * effort;
  }
  bool has_terms() const { return !terms.empty(); }
  bool has_single_term() const { return terms.size() == 1; }
  /// Whether it is one of the tree's coordinates itself, not a multiple or a sum.
  bool is_column() const { return terms.size() == 1 && terms[0].second == 1 && constant == 0; }
};

using LinearQuantity = LinearQuantityOf<double>;

using NodeId = TypedIndex<struct NodeList>;  ///< into Tree::nodes

enum class NodeMotion { weld, revolute, prismatic };

/// Rigid frame N attached to its parent's frame P. Its displacement is x = ratio · y[column] + offset. A displacement
/// that is a sum over several columns takes as many nodes, all about or along the same axis.
template <class S>
struct alignas(storage_alignment<typename S::Scalar>) Node {
  typename S::Scalar ratio = 1;
  typename S::Scalar offset = 0;
  typename S::Rotation R_PF;  ///< N at x = 0; rotates about its z axis or slides along S::slide_direction()
  typename S::Vector p_PF = S::Vector::Zero();
  typename S::Inertia inertia;  ///< of everything fixed to N, about N's origin, in N's axes
  NodeId parent = -1;           ///< −1 only for node 0, the world
  NodeMotion motion = NodeMotion::weld;
  ColumnId column = -1;  ///< −1 for welds
  bool massless = true;
};

/// A frame fixed to a node.
template <class S>
struct FixedFrame {
  NodeId node = 0;
  typename S::Rotation R_N;
  typename S::Vector p_N = S::Vector::Zero();
};

/// One equation of a closure, between frame A (axes a) and frame B (axes b), with d = p_B − p_A.
struct ClosureRow {
  /// Position level: a_i · d = 0 (along), a_i · b_j = 0 (dot). Velocity level: no slip along a_i where A's plane is
  /// touched (slip), a sum of speeds is zero (sum).
  enum class Kind { along, dot, slip, sum } kind;
  int i = 0, j = 0;
};

/// A node that moves a frame, and the sign of its contribution.
struct PathStep {
  NodeId node;
  double sign;
  int term = 0;  ///< index of the term in a sum of speeds
};

/// A term of a sum of speeds: factor times the rate of a column, or times a component of a frame's velocity or angular
/// velocity in world axes or its own.
template <class S>
struct VelocityTerm {
  enum class Of { column, velocity, angular_velocity } of = Of::column;
  bool is_in_body_axes = false;
  int axis = 0;
  typename S::Scalar factor = 1;
  FixedFrame<S> frame;
};

/// A disc or sphere that rolls on the plane through A's origin normal to A's third axis. B's origin is the centre, B's
/// second axis the axis of a disc.
template <class T>
struct RollingContact {
  bool disc = true;
  T radius = 0;
};

/// A joint that is enforced by equations instead of being parametrised.
template <class S>
struct Closure {
  JointId joint = 0;   ///< −1: a constraint of the mechanism
  bool split = false;  ///< welds the body copy carried by a split joint
  FixedFrame<S> a, b;
  std::vector<ClosureRow> rows;
  bool has_coincident_origins = false;  ///< the origins of a and b coincide: nothing slides
  std::vector<int> aligned;             ///< axes k for which a_k · b_k must be positive: excludes flipped assemblies
  std::vector<PathStep> path;  ///< nodes that move b (+1) or a (−1) but not both; of a sum: nodes that move its terms
  RollingContact<typename S::Scalar> contact = {};  ///< of rows `slip`
  std::vector<VelocityTerm<S>> terms = {};          ///< of the one row `sum`
  double row_scale = 1;                             ///< of the row `sum`: its magnitude at unit scaled rates
  model::VariableFunction value = {};               ///< of the row `sum`: function of time that it equals; none: zero

  /// Whether it constrains velocities, not positions.
  bool is_velocity_level() const {
    return !rows.empty() && (rows[0].kind == ClosureRow::Kind::slip || rows[0].kind == ClosureRow::Kind::sum);
  }
};

/// A body, an attachment or a disc: one set of inertial parameters.
template <class S>
struct MassElement {
  FixedFrame<S> frame;          ///< in which the parameters are given
  typename S::Inertia inertia;  ///< about that frame's origin
};

template <class S>
struct Tree {
  std::vector<Node<S>> nodes;         ///< node 0 is the world; parents first
  int columns = 0;                    ///< number of tree coordinates y
  std::vector<FixedFrame<S>> bodies;  ///< frame of every body of the mechanism
  std::vector<Closure<S>> closures;
  int closure_rows = 0;
  int position_rows = 0;              ///< rows of position-level closures; velocity-level closures come after them
  bool has_sliding_closures = false;  ///< some closure has no coincident origins
  /// Every coordinate of the mechanism in terms of y; without terms if the joint is cut.
  std::vector<LinearQuantityOf<typename S::Scalar>> coordinate_expressions;
  std::vector<NodeId> joint_nodes;  ///< per joint: the last node of its chain, −1 if cut
  std::vector<bool> joint_forward;  ///< per joint: traversed from its first to its second body
  /// First nodes of the spherical joints whose coordinates are not prescribed, driven or coupled. Their reference
  /// orientation may be reset at any time (reset_spherical_reference), so that they never reach their singular
  /// position.
  std::vector<NodeId> spherical_joints;
  std::vector<bool>
      is_floating;  ///< per coordinate of the mechanism: of such a joint; its expression holds only until a reset
  /// Bodies whose passive freedom is locked: the spherical joint that carries them lacks its last rotation, like a
  /// universal joint.
  std::vector<model::PassiveFreedom> locked_freedoms;
  std::vector<MassElement<S>> mass_elements;  ///< bodies 1…, then attachments, then discs
  typename S::Scalar mass = 0;
  double characteristic_length = 1;   ///< [m]
  std::vector<int> is_length_column;  ///< per column: 1 if it is a length, 0 if an angle
};

/// @param needed coordinates that must not be cut (those a drive prescribes)
template <class S>
Tree<S> compile_tree(const MechanismOf<typename S::Scalar>& mechanism, const std::vector<CoordinateId>& needed);

/// Makes the present orientation of a spherical joint its reference: its coordinates become zero, nothing moves.
template <class S>
void reset_spherical_reference(Tree<S>& tree, NodeId spherical, typename S::Scalar* y);

/// Shifts an inertia given about the CoM, in a frame's axes, to that frame's origin.
template <class S>
typename S::Inertia inertia_about_origin(const typename S::Scalar& mass, const Vector3Of<typename S::Scalar>& com,
                                         const Matrix3Of<typename S::Scalar>& about_com);

/// The same inertia expressed in the frame in which R, p give the pose of its present frame.
template <class S>
typename S::Inertia transform_inertia(const typename S::Inertia& inertia, const typename S::Rotation& R,
                                      const typename S::Vector& p);

extern template void reset_spherical_reference<Planar>(Tree<Planar>&, NodeId, double*);
extern template void reset_spherical_reference<Spatial>(Tree<Spatial>&, NodeId, double*);
extern template Tree<Planar> compile_tree<Planar>(const Mechanism&, const std::vector<CoordinateId>&);
extern template Tree<Spatial> compile_tree<Spatial>(const Mechanism&, const std::vector<CoordinateId>&);

}  // namespace balance::kinematics
