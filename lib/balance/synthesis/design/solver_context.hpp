#pragma once
/// What every step of a design needs to know about its problem.

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

  /// @throws SpecError where an expression of the spec has no value
  Mechanism mechanism(const VectorX& u) const { return problem.build_mechanism(scaling.to_variables(u)); }
  /// Conditions there; not done where there is no mechanism.
  Conditions conditions_at(const VectorX& u) const;
  /// Why there is no design at u; empty: there may be one.
  std::string infeasibility_reason(const VectorX& u) const;
  /// Why the numbers make no mechanism, as a reader of its spec would say; empty: they make one.
  std::string invalidity_reason(const VectorX& u) const;
  /// All bodies are physical, judged by the mechanism itself.
  bool is_physical(const VectorX& u) const;
  /// The same, and all limits are kept.
  bool is_admissible(const VectorX& u) const;
  /// What is allowed as inequalities g(u) ≥ 0, and their derivatives unless null.
  int inequality_count() const;
  void evaluate_inequalities(const VectorX& u, VectorX& g, MatrixX* jacobian) const;
  /// What is allowed is a convex set.
  bool is_convex() const;
  /// None where there is no goal.
  Conditions derive_conditions(const Mechanism& mechanism) const;

  const DesignProblem& problem;
  SearchBudget& budget;
  VariableScaling scaling;
  VariableClassification classification;
  ConditionOptions options;  ///< with the springs that the free numbers make loose and the loads that they change
  FeatureMap features;
  PhysicalConstraints physical_constraints;
  std::unique_ptr<const DesignLimits> limits;
};

}  // namespace balance::design
