#pragma once
/// Where a mechanism stands, in a few words for a message. Private to motion and the rooms above.

#include "balance/kinematics/tree.hpp"

#include <string>

namespace balance {

/// The first dozen coordinates of the tree: "A 0.5, B -1.2".
template <class S>
std::string format_configuration(const Mechanism& mechanism, const Tree<S>& tree, const double* y);

extern template std::string format_configuration<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
extern template std::string format_configuration<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

}  // namespace balance
