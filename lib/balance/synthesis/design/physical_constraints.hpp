#pragma once
/// Constraints that keep bodies physical: on masses and pseudo-inertias of all elements that the free numbers change.

#include "balance/synthesis/design/feature_map.hpp"

namespace balance::design {

/// Inequalities g(u) ≥ 0, each divided by the size of its quantity. Bodies: positive mass and positive definite Σ =
/// tr(I)/2 · 1 − I about the CoM (planar: positive moment of inertia). Attachments and discs, which may vanish:
/// nonnegative. Springs: nonnegative stiffness. Inequalities implied by the bounds are omitted.
class PhysicalConstraints {
 public:
  PhysicalConstraints(const FeatureMap& map, const VariableClassification& classification,
                      const VectorX& start_features);

  int size() const;
  /// @param features with derivatives `slopes` by unit coordinates (or null)
  void evaluate(const VectorX& features, const MatrixX* slopes, VectorX& g, MatrixX* jacobian) const;
  /// Whether all inequalities hold up to round-off.
  bool is_satisfied(const VectorX& features) const;
  /// Whether the quantities are affine in the variables, so that every g is concave and the physical designs form a
  /// convex set.
  bool is_convex() const { return convex_; }

 private:
  struct InertialBound {
    int feature;    ///< index of the quantity, or the first of six for an inertia
    bool matrix;    ///< whether it stands for the three eigenvalues of Σ
    double size;    ///< of the quantity
    double margin;  ///< minimum of the quantity, in units of size
    bool is_body;   ///< whether the quantity must be positive; else zero is allowed
  };
  void add(const FeatureMap& map, const VariableClassification& classification, const VectorX& start, int feature,
           bool matrix, bool is_body);

  std::vector<InertialBound> items_;
  bool convex_ = true;
};

}  // namespace balance::design
