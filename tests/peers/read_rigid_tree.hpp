#pragma once
/// From a Mechanism to the tree that other libraries take, without the library's own kinematics.

#include "rigid_tree.hpp"

#include "balance/mechanics/model/mechanism.hpp"

namespace balance::peers {

/// @throws NotComparable with what other libraries are not asked about: springs, loads, friction, payloads that
///         come and go, constraints on rates, bodies that spin idly
RigidTree read_rigid_tree(const Mechanism& mechanism);

}  // namespace balance::peers
