#pragma once
/// Solves the conditions for the free numbers.

#include "balance/synthesis/design/solver_context.hpp"

#include <memory>
#include <vector>

namespace balance::design {

// The conditions as equations in the free numbers.

/// Residual of the conditions at one geometry: scaled rows times the parameters.
class ConditionResidual {
 public:
  ConditionResidual(const SolverContext& context, const Conditions& conditions);

  int size() const { return static_cast<int>(matrix_.rows()); }
  const MatrixX& matrix() const { return matrix_; }
  bool has_variable(int row, int variable) const;
  bool is_affine(const std::vector<int>& rows) const;
  void evaluate(const VectorX& u, VectorX& residual, MatrixX* jacobian) const;
  /// Computed from the mechanism itself, to full precision.
  VectorX evaluate_from_mechanism(const VectorX& u) const;
  /// Lower bound of factors · residual within the bounds; minus infinity if unknown.
  double lower_bound(const VectorX& factors) const;

 private:
  const SolverContext& context_;
  MatrixX matrix_;  ///< rows × features
  std::optional<numerics::SparsePolynomial> polynomial_;
};

/// The selected rows minus `target`, followed by rows that vanish if all bodies are physical and all limits are
/// satisfied. The arguments must outlive the system.
numerics::NonlinearSystem make_fixed_geometry_equations(const SolverContext& context, const ConditionResidual& rows,
                                                        std::vector<int> selected_rows, VectorX target);

/// Residual of the goals if lengths and ratios vary, too. Every evaluation builds a mechanism.
/// @param start unit coordinates of a mechanism for which conditions exist
numerics::NonlinearSystem make_geometry_equations(const SolverContext& context, const VectorX& start);

/// The same at configurations of the mechanism at u if it has any; else `otherwise`.
numerics::NonlinearSystem make_equations_near(const SolverContext& context, const VectorX& u,
                                              const numerics::NonlinearSystem& otherwise);

/// Maximum absolute value of the condition rows among the values of the system.
double max_condition_residual(const numerics::NonlinearSystem& equations, const VectorX& values);

/// Affine conditions as matrix · u = rhs with orthonormal rows: independent and complete.
struct LinearConditions {
  MatrixX matrix;
  VectorX rhs;
};
LinearConditions linear_conditions(const numerics::NonlinearSystem& equations, int numbers);

struct ExactSolutions {
  std::vector<VectorX> solutions;        ///< distinct and physical; the one found from the first start comes first
  std::vector<VectorX> rejected;         ///< some that meet the conditions but are not usable
  numerics::LeastSquaresResult closest;  ///< smallest sum of squares found
};

/// Limits of the search for solutions.
struct ExactSearchOptions {
  int max_restarts = 0;                             ///< number of random starts
  int max_solutions = 1;                            ///< number of solutions that suffice
  std::function<bool()> is_proved_infeasible;       ///< called once after several failures; true ends the search
  std::function<bool(const VectorX& u)> is_usable;  ///< filter for solutions; null: accept all
  std::vector<VectorX> starts = {};                 ///< used before the random ones; empty: the start values
};

/// Gauss–Newton from the given starts and from random points of the box.
ExactSolutions find_exact_solutions(const SolverContext& context, const numerics::NonlinearSystem& equations,
                                    const ExactSearchOptions& options);

/// Whether u meets the conditions and is admissible.
bool is_exact(const SolverContext& context, const numerics::NonlinearSystem& equations, const VectorX& u);

/// Returns from a nearby point to the conditions; to full precision if `exact_residual` gives the residual of the
/// mechanism itself.
/// @param exact_residual at one geometry, or null
VectorX refine_solution(const numerics::NonlinearSystem& equations, const VectorX& u,
                        const std::function<VectorX(const VectorX&)>& exact_residual);

/// Orthonormal basis (columns) of the directions in which no condition changes at u; empty: the solution is isolated.
MatrixX tangent_space(const numerics::NonlinearSystem& equations, const VectorX& u);

/// Moves variables that differ by round-off from a bound, their start value or zero onto it, one by one, unless this
/// impairs a condition or the objective.
/// @param objective may be empty
VectorX snap_to_special_values(const SolverContext& context, const numerics::NonlinearSystem& equations,
                               const std::function<double(const VectorX&)>& objective, VectorX u);

/// The solution closest to the start values in unit coordinates, for affine conditions and a convex set of physical
/// designs; std::nullopt if it is not found.
std::optional<VectorX> find_nearest_solution(const SolverContext& context, const LinearConditions& conditions);

}  // namespace balance::design
