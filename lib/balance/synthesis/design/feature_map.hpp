#pragma once
/// Maps free numbers to features of the mechanism without rebuilding it. Masses and inertias are polynomials of low
/// degree in the free numbers of a spec, so a few mechanisms determine them exactly.

#include "balance/foundation/numerics/sparse_polynomial.hpp"
#include "balance/synthesis/design/variable_classification.hpp"

#include <optional>

namespace balance::design {

class FeatureMap {
 public:
  FeatureMap(const VariableScaling& scaling, const DesignProblem& problem,
             const VariableClassification& classification);

  int feature_count() const { return features_; }
  /// In unit coordinates; std::nullopt if some feature is not a polynomial of degree four or less.
  const std::optional<numerics::SparsePolynomial>& polynomial() const { return polynomial_; }
  /// Features and their derivatives (rows) with respect to unit coordinates.
  void evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const;
  /// Computed from the mechanism itself, to full precision; NaN if an expression of the spec has no value.
  VectorX evaluate_from_mechanism(const VectorX& u) const;

 private:
  const VariableScaling& scaling_;
  const DesignProblem& problem_;
  dynamics::FreeSprings loose_;
  int features_;
  std::optional<numerics::SparsePolynomial> polynomial_;
};

/// Jacobian by central differences within the box; the relative error is about 1e-10.
template <class F>
MatrixX central_difference_jacobian(const F& f, const VectorX& u, Eigen::Index rows) {
  constexpr double central_difference_step = 6e-6;
  MatrixX jacobian(rows, u.size());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    VectorX ahead = u, behind = u;
    ahead[i] = std::min(1.0, u[i] + central_difference_step);
    behind[i] = std::max(-1.0, u[i] - central_difference_step);
    jacobian.col(i) = (f(ahead) - f(behind)) / (ahead[i] - behind[i]);
  }
  return jacobian;
}

}  // namespace balance::design
