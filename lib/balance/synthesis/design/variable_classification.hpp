#pragma once
/// The free numbers in coordinates of their own: −1 at the lower bound, +1 at the upper one.

#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/geometry_features.hpp"

#include <cstdint>
#include <random>

namespace balance::design {

class VariableScaling {
 public:
  /// @throws std::invalid_argument if a bound is not finite, bounds are in the wrong order or a start lies outside them
  explicit VariableScaling(const std::vector<DesignVariable>& variables);

  int size() const { return static_cast<int>(half_.size()); }
  /// The start values in unit coordinates.
  const VectorX& start() const { return start_; }
  /// The free numbers [SI], never outside their bounds; bounds and start values are hit exactly.
  VectorX to_variables(const VectorX& u) const;
  /// Middle and half the width of every interval.
  const VectorX& centre() const { return centre_; }
  const VectorX& half_width() const { return half_; }
  const VectorX& lower() const { return lower_; }
  const VectorX& upper() const { return upper_; }

 private:
  VectorX lower_, upper_, start_numbers_, start_, centre_, half_;
};

/// Clips unit coordinates to the box.
inline VectorX clip_to_unit_box(const VectorX& u) { return u.cwiseMax(-1.0).cwiseMin(1.0); }

/// Uniform numbers that are the same with every compiler.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : engine_(seed) {}
  double operator()(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  VectorX sample_point(int size, double lower = -1, double upper = 1) {
    VectorX u(size);
    for (double& value : u) value = (*this)(lower, upper);
    return u;
  }

 private:
  std::mt19937_64 engine_;
};

/// A first look at what the free numbers change: the mechanism at one point in general position and with every number
/// changed alone.
struct VariableClassification {
  VectorX base;       ///< unit coordinates in general position
  VectorX perturbed;  ///< per number: its other value
  Mechanism base_mechanism;
  FreeSprings loose_springs;       ///< springs whose ends are parameters, not geometry
  std::vector<bool> is_geometric;  ///< per number: it changes the geometry
  VectorX base_features;
  std::vector<VectorX> perturbed_features;  ///< with number i changed alone
  double change_threshold = 1e-12;          ///< relative change of a feature that counts as one

  bool has_geometric() const;
  /// Number i changes feature f.
  bool has_effect(int variable, int feature) const;
};

VariableClassification classify_variables(const VariableScaling& box, const DesignProblem& problem);

}  // namespace balance::design
