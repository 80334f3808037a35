#pragma once
/// The objective as a function of unit coordinates.

#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// Of a figure, in parts of the largest of its values at hand.
inline constexpr double relative_figure_round_off = 1e-12;

class ScaledObjective {
 public:
  /// @param objective must outlive it, as the context must
  ScaledObjective(const SolverContext& context, const Objective& objective);

  /// @param gradient written if not null (by differences where the objective has none)
  /// @return not finite where it cannot be computed
  double operator()(const VectorX& u, VectorX* gradient) const;
  /// Why there is no value at u; may be empty.
  std::string failure_reason(const VectorX& u) const;
  /// The same as a sum of maxima, with slopes; nothing where it cannot be computed. Only where they are known.
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& u) const;
  bool has_max_terms() const { return is_simulated() && context_.problem.max_terms; }
  /// Every value takes a simulation.
  bool is_simulated() const { return static_cast<bool>(objective_.of_variables); }
  /// Convex in the free numbers: convex in parameters that are affine in the numbers wherever it depends on them.
  bool is_convex() const { return convex_; }
  /// Values no larger are round-off: they are measured by those at the start, in the middle and at the ends of the bounds.
  double round_off() const;
  /// No value is below it.
  double lower_bound() const { return objective_.lower_bound; }

 private:
  bool is_affine_in_variables() const;
  double evaluate_by_simulation(const VectorX& u) const;
  VectorX gradient_by_simulation(const VectorX& u) const;

  const SolverContext& context_;
  const Objective& objective_;
  std::vector<int> parameters_;  ///< the features that are its arguments
  bool convex_ = false;
};

// Figures that a design must keep to, as inequalities in unit coordinates.

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
