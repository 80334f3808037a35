#pragma once
/// A mechanism as other libraries for multibody dynamics take it: a tree of rigid bodies that move about single axes,
/// and the equations of its cut joints. C++17: a peer's headers may not be C++20.

#include "balance/foundation/base/types.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace balance::peers {

/// Why a mechanism is not compared, to be read after its name: "has springs".
struct NotComparable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Masses [kg] and inertias [kg m^2] are no smaller, because some libraries refuse bodies without: far below round-off.
inline constexpr double negligible_mass = 2e-15;

/// A rotation about an axis, or a slide along it. Of a body's motions, the later ones are carried along by the earlier.
struct ElementaryMotion {
  bool is_rotation = true;
  Vector3 axis = Vector3::UnitZ();  ///< unit vector, in the axes of its body
};

/// The ground, as a body's index.
inline constexpr int tree_ground = -1;

/// At zero coordinates the axes of all bodies are those of the world.
struct TreeBody {
  int parent = tree_ground;               ///< index of an earlier body
  Vector3 position = Vector3::Zero();     ///< of its origin in the parent's axes at zero coordinates [m]
  std::vector<ElementaryMotion> motions;  ///< in the order in which they move it; none: welded to its parent
  double mass = negligible_mass;          ///< [kg]
  Vector3 com = Vector3::Zero();          ///< [m]
  Matrix3 inertia = negligible_mass * Matrix3::Identity();  ///< about the centre of mass [kg m^2]
};

/// A point of a body and three axes fixed to it, in the body's axes.
struct BodyFrame {
  int body = tree_ground;
  Vector3 point = Vector3::Zero();     ///< [m]
  Matrix3 axes = Matrix3::Identity();  ///< columns
};

/// Equations between frames a and b, with d from a's point to b's: a_i · d = 0, or a_i · b_j = 0.
struct ClosureEquation {
  bool is_along = true;
  int i = 0;
  int j = 0;
};

/// A cut joint, or a joint that is not cut although it closes a loop: a body is then welded to its copy in the tree.
struct CutJoint {
  std::string name;
  BodyFrame a, b;
  std::vector<ClosureEquation> equations;
};

/// The tree's coordinates are the displacements of all motions, body by body.
struct RigidTree {
  bool is_planar = true;
  Vector3 gravity = Vector3::Zero();  ///< [m/s^2]
  std::vector<TreeBody> bodies;       ///< depth first
  std::vector<CutJoint> cut_joints;
  MatrixX motions_of_coordinates;  ///< motions × coordinates of the mechanism: displacement = matrix · coordinates
  MatrixX motions_of_independent;  ///< motions × tree coordinates that follow no other: their rates, the same way
  MatrixX efforts_on_independent;  ///< independent × actuators: generalised forces of unit efforts

  int motion_count() const { return static_cast<int>(motions_of_coordinates.rows()); }
};

}  // namespace balance::peers
