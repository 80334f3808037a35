#pragma once
/// The geometries over which lengths are bounded: general lengths, and each special geometry with its own closures.

#include "balance/synthesis/certificate/assembly_conditions.hpp"
#include "balance/synthesis/certificate/box_program.hpp"
#include "balance/synthesis/certificate/virtual_linkage.hpp"

namespace balance::certificate {

/// Relative: sums of mass limits are exceeded by more only if nothing balances.
inline constexpr double mass_sum_tolerance = 1e-12;
inline constexpr const char* general_lengths_name = "general lengths";

struct LengthGeometry {
  std::string name;
  LengthSubstitution substitution;  ///< lengths that follow from the others
  PlanarLinkage linkage;
  VirtualLinkage dual;
  std::vector<LengthCondition> conditions;  ///< that all its lengths meet
  LengthBox box;
  double min_value = 0, max_value = 0;  ///< of the objective within the mass limits [kg]
  /// The same without free counterweights, and by how much a bound must exceed all limits to show that nothing
  /// balances: conditions that are met but for round-off can have a bound [kg].
  double max_fixed_size = 0, impossibility_margin = 0;
};

struct LengthGeometries {
  /// The first has general lengths, unless all lengths are special.
  std::vector<LengthGeometry> geometries;
  std::vector<std::string> uncovered;  ///< special geometries within the bounds that are none of them
  std::string reason;                  ///< why there are none; completes "no certificate because …"
};

/// Their conditions are compared with those of the library at random lengths.
/// @param required_trajectories as in LengthBoundOptions
LengthGeometries list_length_geometries(const DesignSpace& space, const std::vector<int>& required_trajectories);

}  // namespace balance::certificate
