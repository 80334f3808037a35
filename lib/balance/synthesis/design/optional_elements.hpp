#pragma once
/// Elements of a spec that a design may leave out.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/design/design_problem.hpp"

namespace balance::design {

/// An element can be left out if each of its masses, moments of inertia, stiffness and preload vanishes when some free
/// number is zero.
/// @return the constraints of design.choose; variables are indices into start.free_numbers
/// @throws std::invalid_argument if a named element, or every element of a section, cannot be left out
std::vector<CardinalityConstraint> list_optional_elements(const DesignSpace& space);

}  // namespace balance::design
