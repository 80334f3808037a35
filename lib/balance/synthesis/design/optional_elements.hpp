#pragma once
/// What a spec offers a design to choose among.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/design/design_problem.hpp"

namespace balance {

/// An element can be left out if each of its masses, moments of inertia, stiffness and preload vanishes where one free number is zero.
/// @return of design.choose; numbers are positions among start.free_numbers
/// @throws std::invalid_argument for one that is named and cannot, or where none can
std::vector<CardinalityConstraint> list_optional_elements(const DesignSpace& space);

}  // namespace balance
