#pragma once
/// The numbers that describe a mechanism in a design: its parameters, the quantities that decide whether its bodies are
/// physical, and its geometry.

#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

#include <vector>

namespace balance::design {

/// Position of an element in the list of features, which consists of the parameters and known terms, then the mass and
/// the inertia about the CoM of each element, then the stiffnesses of the springs.
struct ElementFeatures {
  dynamics::ParameterOwner bearer = dynamics::ParameterOwner::body;
  int index = 0;
  int mass = -1;     ///< index of the feature; for a spring: its stiffness
  int inertia = -1;  ///< index of the first feature: planar 1, spatial Ixx, Iyy, Izz, Ixy, Ixz, Iyz; for a spring: none
};
std::vector<ElementFeatures> list_element_features(const Mechanism& mechanism, const dynamics::FreeSprings& loose);

VectorX compute_features(const Mechanism& mechanism, const dynamics::FreeSprings& loose);

/// Everything that the conditions depend on besides the parameters: lengths, axes, ratios, free lengths, end points of
/// springs that are not loose, points of application of loads, gravity, tool.
VectorX collect_geometry(const Mechanism& mechanism, const dynamics::FreeSprings& loose);

/// The same with the points of speeds in which the conditions are stated, and with all that moves the centre of mass if
/// its velocity is among them.
VectorX collect_condition_geometry(const Mechanism& mechanism, const ConditionOptions& options);

/// Unit of each parameter: the total mass (or the largest stiffness) times a power of the characteristic length; for a
/// known term, its own size.
VectorX parameter_scales(const Mechanism& mechanism, const dynamics::FreeSprings& loose);

/// Whether the numbers agree up to round-off.
bool is_equal_to_rounding(const VectorX& a, const VectorX& b);

}  // namespace balance::design
