#pragma once
/// Numbers that meet the conditions.

#include "balance/synthesis/design/solver_context.hpp"

#include <memory>
#include <vector>

namespace balance::design {

// The conditions as equations in the free numbers.

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

/// A u = c with orthonormal rows, where the conditions are affine: independent and complete.
struct LinearConditions {
  MatrixX a;
  VectorX c;
};
LinearConditions linear_conditions(const NonlinearSystem& equations, int numbers);

struct ExactSolutions {
  std::vector<VectorX> solutions;  ///< distinct and physical; the one reached from the start values first
  std::vector<VectorX> rejected;   ///< some that meet the conditions but are no designs
  LeastSquaresResult closest;      ///< smallest sum of squares where there is no solution
};

/// How long to look for solutions.
struct ExactSearchOptions {
  int max_restarts = 0;   ///< at most
  int max_solutions = 1;  ///< solutions that are enough
  std::function<bool()>
      is_proved_infeasible;  ///< asked once after a few failures: it is proved that there is no solution
  std::function<bool(const VectorX& u)> is_usable;  ///< a solution counts; null: all do
  std::vector<VectorX> starts = {};                 ///< starts before the random ones; none: the start values
};

/// Gauss–Newton from the first starts and from random points of the box.
ExactSolutions find_exact_solutions(const SolverContext& context, const NonlinearSystem& equations,
                                    const ExactSearchOptions& effort);

/// Within bounds, met and physical.
bool is_exact(const SolverContext& context, const NonlinearSystem& equations, const VectorX& u);

/// Back onto the conditions from a point near them; to the last digit where `exact` gives the residual of the mechanism itself.
/// @param exact residual at one geometry, or null
VectorX refine_solution(const NonlinearSystem& equations, const VectorX& u,
                        const std::function<VectorX(const VectorX&)>& exact);

/// Orthonormal directions (columns) in which no condition changes at u; none: the solution is the only one near it.
MatrixX tangent_space(const NonlinearSystem& equations, const VectorX& u);

/// Numbers that are off their bounds, their start values or zero by round-off are put there, one by one, unless a condition
/// or the objective suffers.
/// @param merit may be empty
VectorX snap_to_special_values(const SolverContext& context, const NonlinearSystem& equations,
                               const std::function<double(const VectorX&)>& merit, VectorX u);

/// The solution nearest to the start values, in widths of the bounds, where conditions are affine and the physical designs
/// form a convex set; nothing if it is not found.
std::optional<VectorX> find_nearest_solution(const SolverContext& context, const LinearConditions& conditions);

}  // namespace balance::design
