#pragma once
/// Which coordinates a state of a mechanism is given in. Private to inverse.

#include "balance/kinematics/assembly.hpp"

#include <string>
#include <vector>

namespace balance {

/// A mechanism compiled so that its independent coordinates are coordinates of the tree that need no reference orientation.
template <class S>
struct IndependentCoordinates {
  Tree<S> tree;
  std::vector<CoordinateId> needed;       ///< coordinates that the tree was compiled with
  std::vector<CoordinateId> coordinates;  ///< as many as freedoms, and they determine the others
  int freedoms = 0;                       ///< by rank
  bool redundant = false;                 ///< closures have more rows than rank
  std::string note;                       ///< which coordinates were chosen if nobody asked for them; else empty
};

/// @param names may be empty: see InverseOptions::independent
/// @throws std::invalid_argument if the loops cannot be closed, or a name does not exist, or these coordinates do not determine the
///         motion
template <class S>
IndependentCoordinates<S> choose_independent_coordinates(const Mechanism& mechanism,
                                                         const std::vector<std::string>& names);

/// The mechanism's coordinate of this name.
/// @param what is named, for the message
/// @throws std::invalid_argument if there is none
int require_coordinate(const Mechanism& mechanism, const std::string& name, const char* what);

extern template IndependentCoordinates<Planar> choose_independent_coordinates<Planar>(const Mechanism&,
                                                                                      const std::vector<std::string>&);
extern template IndependentCoordinates<Spatial> choose_independent_coordinates<Spatial>(
    const Mechanism&, const std::vector<std::string>&);

}  // namespace balance
