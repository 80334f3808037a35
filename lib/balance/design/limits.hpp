#pragma once
/// Figures that a design must keep to, as inequalities in unit coordinates. Private to design.

#include "balance/design/figure_of_merit.hpp"

namespace balance::design {

/// How far a value is beyond a limit, in parts of its bound (of one, if the bound is zero); negative: what is left of it.
double relative_violation(const DesignLimit& limit, double value);

class DesignLimits {
 public:
  explicit DesignLimits(const SolverContext& context);

  int size() const { return static_cast<int>(merits_.size()); }
  /// The numbers that keep all limits form a convex set.
  bool is_convex() const;
  /// g = −violation, and its derivatives unless null. Not finite where a figure has no value.
  void evaluate(const VectorX& u, VectorX& g, MatrixX* jacobian) const;
  /// All are kept, to round-off.
  bool is_satisfied(const VectorX& u) const;

 private:
  const std::vector<DesignLimit>& limits_;
  std::vector<ScaledObjective> merits_;
};

}  // namespace balance::design
