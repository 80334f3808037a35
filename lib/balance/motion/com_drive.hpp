#pragma once
/// Whether the centre of mass moves at all, so that it can drive a mechanism. Private to motion.

#include "balance/kinematics/assembly.hpp"

#include <string>

namespace balance {

/// Looks at the velocities that the loops allow, at a few configurations around y.
/// @param y closes the loops
/// @param components world components of the centre of mass that are to be prescribed
/// @return why they cannot be: the mechanism is force balanced, wholly or in a direction; empty if they can
template <class S>
std::string check_com_mobility(const Tree<S>& tree, const VectorX& y, const std::vector<int>& components);

extern template std::string check_com_mobility<Planar>(const Tree<Planar>&, const VectorX&, const std::vector<int>&);
extern template std::string check_com_mobility<Spatial>(const Tree<Spatial>&, const VectorX&, const std::vector<int>&);

}  // namespace balance
