#pragma once
/// The conditions as equations in the free numbers. Private to design.

#include "balance/design/context.hpp"

#include <memory>
#include <vector>

namespace balance::designing {

/// Conditions of one geometry: scaled rows times the parameters.
class FixedRows {
 public:
  FixedRows(const Context& context, const Conditions& conditions);

  int size() const { return static_cast<int>(matrix_.rows()); }
  const MatrixX& matrix() const { return matrix_; }
  bool touches(int row, int variable) const;
  bool affine(const std::vector<int>& rows) const;
  void evaluate(const VectorX& u, VectorX& residual, MatrixX* jacobian) const;
  /// From the mechanism itself, to the last digit.
  VectorX exact(const VectorX& u) const;
  /// What factors · rows cannot fall below within the bounds; minus infinity if it is not known.
  double least(const VectorX& factors) const;

 private:
  const Context& context_;
  MatrixX matrix_;  ///< rows × features
  std::optional<Polynomial> polynomial_;
};

/// Some of the rows, less `target`, with the rows that vanish where bodies are physical. The arguments must outlive them.
Equations fixed_equations(const Context& context, const FixedRows& rows, std::vector<int> which, VectorX target);

/// The goals' residual while lengths and ratios change too. Every evaluation builds a mechanism.
/// @param start unit coordinates of a mechanism that has conditions
Equations geometric_equations(const Context& context, const VectorX& start);

/// The same at configurations of the mechanism at u, if it has any; else `otherwise`.
Equations equations_near(const Context& context, const VectorX& u, const Equations& otherwise);

/// Largest size of the conditions' rows among an equation's values.
double worst(const Equations& equations, const VectorX& values);

}  // namespace balance::designing
