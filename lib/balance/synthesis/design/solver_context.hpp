#pragma once
/// Data shared by all steps of a design computation.

#include "balance/foundation/numerics/levenberg_marquardt.hpp"
#include "balance/synthesis/design/physical_constraints.hpp"
#include "balance/synthesis/design/search_budget.hpp"

#include <memory>

namespace balance::design {

class DesignLimits;

struct SolverContext {
  SolverContext(const DesignProblem& problem, SearchBudget& budget);
  SolverContext(const SolverContext&) = delete;
  ~SolverContext();

  /// @throws SpecError if an expression of the spec has no value
  Mechanism mechanism(const VectorX& u) const { return problem.model->build_mechanism(scaling.to_variables(u)); }
  /// Conditions at u. The status is not `done` if there is no mechanism.
  Conditions conditions_at(const VectorX& u) const;
  /// DesignModel::convex_terms and convex_limits at u; std::nullopt also where they have no value or the time is over.
  std::optional<std::vector<AffineFigure>> convex_terms(const VectorX& u, FigureSampling sampling) const;
  std::optional<std::vector<ConvexLimit>> convex_limits(const VectorX& u) const;
  /// Why no design is possible at u; empty if nothing rules it out.
  std::string infeasibility_reason(const VectorX& u) const;
  /// Why the mechanism at u is invalid, phrased for readers of the spec; empty if it is valid.
  std::string invalidity_reason(const VectorX& u) const;
  /// Whether the mechanism is valid and all bodies are physical, evaluated from the mechanism instead of the fitted
  /// polynomials.
  bool is_physical(const VectorX& u) const;
  /// Whether the mechanism is physical and satisfies all limits.
  bool is_admissible(const VectorX& u) const;
  /// Physical constraints and limits as inequalities g(u) ≥ 0, with derivatives unless `jacobian` is null.
  int inequality_count() const;
  void evaluate_inequalities(const VectorX& u, VectorX& g, MatrixX* jacobian) const;
  /// Whether the feasible set is convex.
  bool is_convex() const;
  /// Without goals: no conditions, with status `done`.
  Conditions derive_conditions(const Mechanism& mechanism) const;

  const DesignProblem& problem;
  SearchBudget& budget;
  VariableScaling scaling;
  VariableClassification classification;
  ConditionOptions options;  ///< including the springs made loose, and the loads changed, by the free numbers
  FeatureMap features;
  PhysicalConstraints physical_constraints;
  std::unique_ptr<const DesignLimits> limits;
};

}  // namespace balance::design
