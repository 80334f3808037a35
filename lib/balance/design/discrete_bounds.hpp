#pragma once
/// What parts of a design problem with sizes and choices cannot be better than. Private to design.

#include "balance/design/branching.hpp"
#include "balance/design/equations.hpp"

#include <memory>

namespace balance::design {

/// What a search among sizes looks for.
enum class BranchObjective {
  constrained_figure,  ///< designs that meet the conditions, of them the least figure
  figure,              ///< the least figure, whatever the conditions
  residual,            ///< the least that is left of the conditions
};

/// The problem within a branch, without sizes and choices.
/// @param seconds that its search may take
DesignProblem restrict_to_node(const DesignProblem& problem, const BranchNode& branch, double seconds);

class NodeBounds {
 public:
  explicit NodeBounds(const DesignProblem& problem) : problem_(problem) {}

  struct Bound {
    bool has_relaxation = false;  ///< there is a convex problem that says so
    bool is_feasible = true;      ///< false: the branch holds no such design
    double lower_bound =
        -std::numeric_limits<double>::infinity();  ///< no such design has a figure (what is left) below it
    VectorX x;                                     ///< numbers between the sizes that come near it; may be empty
  };
  /// Conditions of all designs, in one scale; null where they are not the same for all.
  const Conditions* shared_conditions(const BranchNode& root);
  Bound operator()(const BranchNode& branch, const VariableDomain& part, BranchObjective wanted);

 private:
  /// One geometry, and all that can be decided at it.
  struct GeometryRelaxation {
    GeometryRelaxation(const DesignProblem& whole, const BranchNode& branch);
    DesignProblem problem;
    SearchBudget budget;
    SolverContext context;
    Conditions conditions;
    std::optional<ConicRelaxation> relaxation;
    bool is_infeasible = false;  ///< a condition on parameters is not met, and no number changes it
    double fixed_residual = 0;   ///< what is left of conditions that no number changes
    VectorX outer;
  };
  const GeometryRelaxation* relaxation_at(const BranchNode& branch);
  void find_outer(const BranchNode& root);

  const DesignProblem& problem_;
  std::vector<int> outer_;  ///< numbers whose values must be decided first
  std::unique_ptr<const GeometryRelaxation> place_;
  bool tried_ = false;
};

}  // namespace balance::design
