#pragma once
/// The free numbers in unit coordinates: −1 at the lower bound, +1 at the upper one.

#include "balance/foundation/numerics/random.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/geometry_features.hpp"

namespace balance::design {

class VariableScaling {
 public:
  /// @throws std::invalid_argument if a bound is not finite, the bounds are in the wrong order or the start lies
  /// outside them
  explicit VariableScaling(const std::vector<DesignVariable>& variables);

  int size() const { return static_cast<int>(half_.size()); }
  /// The start values in unit coordinates.
  const VectorX& start() const { return start_; }
  /// The free numbers [SI], clamped to their bounds; bounds and start values are reproduced exactly.
  VectorX to_variables(const VectorX& u) const;
  /// The inverse; numbers whose bounds coincide become 0.
  VectorX to_unit(const VectorX& x) const;
  double to_unit(int i, double x) const;
  /// Centre and half width of each interval.
  const VectorX& centre() const { return centre_; }
  const VectorX& half_width() const { return half_; }
  const VectorX& lower() const { return lower_; }
  const VectorX& upper() const { return upper_; }

 private:
  VectorX lower_, upper_, start_numbers_, start_, centre_, half_;
};

/// Clips unit coordinates to the box.
inline VectorX clip_to_unit_box(const VectorX& u) { return u.cwiseMax(-1.0).cwiseMin(1.0); }

/// First analysis of which features each free number changes: the mechanism at one point in general position, and with
/// each number changed separately.
struct VariableClassification {
  VectorX base;       ///< unit coordinates in general position
  VectorX perturbed;  ///< another value of each variable
  Mechanism base_mechanism;
  dynamics::FreeSprings loose_springs;  ///< springs whose end points are parameters rather than geometry
  std::vector<bool> is_geometric;       ///< whether each variable changes the geometry
  VectorX base_features;
  std::vector<VectorX> perturbed_features;  ///< with only variable i changed
  double change_threshold = 1e-12;          ///< relative change of a feature that counts as a change

  bool has_geometric() const;
  /// Whether variable i changes feature f.
  bool has_effect(int variable, int feature) const;
};

VariableClassification classify_variables(const VariableScaling& scaling, const DesignProblem& problem);

}  // namespace balance::design
