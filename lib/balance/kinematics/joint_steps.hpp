#pragma once
/// What a joint is made of: the elementary motions that a joint of the tree allows, and the equations that enforce a cut one.
/// Private to kinematics.

#include "balance/kinematics/tree.hpp"

#include <vector>

namespace balance {

/// One elementary motion of a joint: about or along `direction`, in the first body's axes at coordinate zero.
template <class T>
struct ElementaryMotion {
  NodeMotion motion;
  Vector3Of<T> direction;
  int index;           ///< coordinate within the joint
  T axial_offset = 0;  ///< to where the next one is, along the joint's axis [m]
};

/// In order from the first body to the second.
template <class T>
std::vector<ElementaryMotion<T>> list_elementary_motions(const JointOf<T>& joint);

/// Axes in which a node turns about z or slides along its space's slide direction.
template <class S>
Matrix3Of<typename S::Scalar> node_axes(const ElementaryMotion<typename S::Scalar>& step);

/// The axes in which the constraints of a cut joint are simple: z (planar: x) along the joint's axis; universal: x along
/// the second axis.
template <class S>
Matrix3Of<typename S::Scalar> closure_axes(const JointOf<typename S::Scalar>& joint);

/// Gives a closure the rows of a cut joint of this type.
/// @throws std::invalid_argument if the type does not exist in this space
template <class S>
void set_closure_rows(JointType type, Closure<S>& closure);

}  // namespace balance
