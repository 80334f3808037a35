#pragma once
/// The numbers by which a design sees a mechanism: its parameters, what decides whether its bodies are physical, and its
/// geometry.

#include "balance/synthesis/conditions/known_terms.hpp"

#include <vector>

namespace balance::design {

/// Where the numbers of a mechanism stand in its list of features: first the parameters and known terms, then every element's mass and
/// its inertia about its CoM, then the springs' stiffnesses.
struct ElementFeatures {
  ParameterOwner bearer = ParameterOwner::body;
  int index = 0;
  int mass = -1;     ///< feature; of a spring: the stiffness
  int inertia = -1;  ///< first feature: planar one, spatial Ixx, Iyy, Izz, Ixy, Ixz, Iyz; of a spring: none
};
std::vector<ElementFeatures> list_element_features(const Mechanism& mechanism, const FreeSprings& loose);

VectorX compute_features(const Mechanism& mechanism, const FreeSprings& loose);

/// Everything that conditions depend on besides the parameters: lengths, axes, ratios, free lengths, ends of springs that are
/// not loose, places of loads, gravity, tool.
VectorX collect_geometry(const Mechanism& mechanism, const FreeSprings& loose);

/// One unit per parameter: the mechanism's mass (the stiffest spring's stiffness) times its length to the parameter's power;
/// of a known term its size.
VectorX parameter_scales(const Mechanism& mechanism, const FreeSprings& loose);

/// The same numbers but for round-off.
bool is_equal_to_rounding(const VectorX& a, const VectorX& b);

}  // namespace balance::design
