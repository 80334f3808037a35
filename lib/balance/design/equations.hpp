#pragma once
/// The conditions as equations in the free numbers. Private to design.

#include "balance/design/context.hpp"

#include <memory>
#include <vector>

namespace balance::design {

/// Conditions of one geometry: scaled rows times the parameters.
class ConditionResidual {
 public:
  ConditionResidual(const SolverContext& context, const Conditions& conditions);

  int size() const { return static_cast<int>(matrix_.rows()); }
  const MatrixX& matrix() const { return matrix_; }
  bool has_variable(int row, int variable) const;
  bool is_affine(const std::vector<int>& rows) const;
  void evaluate(const VectorX& u, VectorX& residual, MatrixX* jacobian) const;
  /// From the mechanism itself, to the last digit.
  VectorX evaluate_from_mechanism(const VectorX& u) const;
  /// What factors · rows cannot fall below within the bounds; minus infinity if it is not known.
  double lower_bound(const VectorX& factors) const;

 private:
  const SolverContext& context_;
  MatrixX matrix_;  ///< rows × features
  std::optional<SparsePolynomial> polynomial_;
};

/// Some of the rows, less `target`, with the rows that vanish where bodies are physical. The arguments must outlive them.
NonlinearSystem make_fixed_geometry_equations(const SolverContext& context, const ConditionResidual& rows,
                                              std::vector<int> which, VectorX target);

/// The goals' residual while lengths and ratios change too. Every evaluation builds a mechanism.
/// @param start unit coordinates of a mechanism that has conditions
NonlinearSystem make_geometry_equations(const SolverContext& context, const VectorX& start);

/// The same at configurations of the mechanism at u, if it has any; else `otherwise`.
NonlinearSystem make_equations_near(const SolverContext& context, const VectorX& u, const NonlinearSystem& otherwise);

/// Largest size of the conditions' rows among an equation's values.
double max_condition_residual(const NonlinearSystem& equations, const VectorX& values);

}  // namespace balance::design
