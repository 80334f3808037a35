#pragma once
/// The numbers by which a design sees a mechanism: its parameters, what decides whether its bodies are physical, and its
/// geometry. Private to design and to the rooms that open it up.

#include "balance/conditions/known_terms.hpp"

#include <vector>

namespace balance::designing {

/// Where the numbers of a mechanism stand in its list of features: first the parameters and known terms, then every element's mass and
/// its inertia about its CoM, then the springs' stiffnesses.
struct Element {
  Bearer bearer = Bearer::body;
  int index = 0;
  int mass = -1;     ///< feature; of a spring: the stiffness
  int inertia = -1;  ///< first feature: planar one, spatial Ixx, Iyy, Izz, Ixy, Ixz, Iyz; of a spring: none
};
std::vector<Element> list_elements(const Mechanism& mechanism, const LooseSprings& loose);

VectorX features(const Mechanism& mechanism, const LooseSprings& loose);

/// Everything that conditions depend on besides the parameters: lengths, axes, ratios, free lengths, ends of springs that are
/// not loose, places of loads, gravity, tool.
VectorX geometry(const Mechanism& mechanism, const LooseSprings& loose);

/// One unit per parameter: the mechanism's mass (the stiffest spring's stiffness) times its length to the parameter's power;
/// of a known term its size.
VectorX parameter_units(const Mechanism& mechanism, const LooseSprings& loose);

/// The same numbers but for round-off.
bool same_numbers(const VectorX& a, const VectorX& b);

}  // namespace balance::designing
