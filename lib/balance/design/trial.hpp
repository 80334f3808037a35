#pragma once
/// Numbers at one geometry, and which of several are better. Private to design.

#include "balance/design/equations.hpp"
#include "balance/design/figure_of_merit.hpp"

#include <limits>

namespace balance::design {

struct TrialDesign {
  VectorX u;                 ///< all numbers
  bool is_feasible = false;  ///< no obstacle
  bool is_balanced = false;
  double figure = std::numeric_limits<double>::quiet_NaN();  ///< the objective
  double residual =
      std::numeric_limits<double>::quiet_NaN();  ///< norm of what is left of the goal at the equations' samples
};

class TrialEvaluator {
 public:
  /// @param equations of the goal, or none
  /// @param merit null: none
  TrialEvaluator(const SolverContext& context, const NonlinearSystem& equations, const ScaledObjective* merit);

  /// The objective comes before the conditions where these cannot be met.
  bool is_figure_first() const { return objective_ != nullptr && !context_.problem.objective->is_secondary; }
  /// Balanced before not, then by the objective, or by what is left.
  double cost(const TrialDesign& trial) const;
  void update_best(TrialDesign& best, TrialDesign trial) const;

  /// By the conditions of its own geometry, derived anew.
  bool is_balanced(const VectorX& u) const;
  /// All numbers as they stand.
  TrialDesign evaluate(const VectorX& u) const;
  /// At the lengths of u: the other numbers solved for by themselves.
  TrialDesign solve_at_geometry(const VectorX& u) const;

 private:
  void evaluate_figures(TrialDesign& trial) const;

  const SolverContext& context_;
  const NonlinearSystem& equations_;
  const ScaledObjective* objective_;
  std::vector<int> others_;  ///< numbers that do not change the geometry
};

}  // namespace balance::design
