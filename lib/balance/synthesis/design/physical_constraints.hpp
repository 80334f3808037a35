#pragma once
/// What keeps bodies physical: masses and pseudo-inertias of everything that the free numbers change.

#include "balance/synthesis/design/feature_map.hpp"

namespace balance::design {

/// Inequalities g(u) ≥ 0, each divided by the size of its quantity. Bodies: mass positive and Σ = tr(I)/2 · 1 − I about the
/// CoM positive definite (planar: the moment of inertia positive); attachments and discs, which may vanish: not negative;
/// springs: stiffness not negative. Those that the bounds imply are left out.
class PhysicalConstraints {
 public:
  PhysicalConstraints(const FeatureMap& map, const VariableClassification& survey, const VectorX& start_features);

  int size() const;
  /// From features and their derivatives by unit coordinates (or null).
  void evaluate(const VectorX& features, const MatrixX* slopes, VectorX& g, MatrixX* jacobian) const;
  /// All hold, to round-off.
  bool is_satisfied(const VectorX& features) const;
  /// The quantities are affine in the numbers, so that every g is concave and the physical designs form a convex set.
  bool is_convex() const { return convex_; }

 private:
  struct InertialBound {
    int feature;    ///< the quantity, or the first of six of an inertia
    bool matrix;    ///< three eigenvalues of Σ
    double size;    ///< of the quantity
    double margin;  ///< that g keeps, in units of size
  };
  void add(const FeatureMap& map, const VariableClassification& survey, const VectorX& start, int feature, bool matrix,
           bool body);

  std::vector<InertialBound> items_;
  bool convex_ = true;
};

}  // namespace balance::design
