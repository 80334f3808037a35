#pragma once
/// Links that lie in line with each other: what dead points and outstretched arms are recognised by. Private to motion.

#include "balance/kinematics/state.hpp"
#include "balance/model/mechanism.hpp"

#include <string>

namespace balance {

/// "a and b are in line at B"; empty if no two links are, or so many that it says nothing.
/// @param state poses
template <class S>
std::string describe_collinear_links(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state);

extern template std::string describe_collinear_links<Planar>(const Mechanism&, const Tree<Planar>&,
                                                             const TreeState<Planar>&);
extern template std::string describe_collinear_links<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                              const TreeState<Spatial>&);

}  // namespace balance
