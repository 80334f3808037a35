#pragma once
/// Analysis of a design's conditions: which variables occur in them, which conditions are unmet, and why they cannot be
/// met.

#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// For each condition, the free variables that change it. @param u point at which the conditions were derived; the
/// geometry may be free
std::vector<std::vector<int>> find_condition_variables(const SolverContext& context, const Conditions& conditions,
                                                       const VectorX& u);

/// Proof that the conditions at a fixed geometry cannot be met, either for any masses or within the bounds.
/// @param residual of the best design
std::optional<conditions::InfeasibilityCertificate> find_infeasibility_certificate(const SolverContext& context,
                                                                                   const Conditions& conditions,
                                                                                   const ConditionResidual& rows,
                                                                                   const VectorX& residual);

/// Derives status, unmet conditions and reason from the residuals, the proof and the fixed conditions.
void determine_status(DesignOutcome& outcome);

// Dimension of the set of equivalent designs.

/// The figures of an objective near a design, at its geometry and along its motion: statistics of functions that are
/// affine in the parameters.
class FigureFace {
 public:
  /// @return std::nullopt if the model has no affine terms, or no motion at u
  static std::optional<FigureFace> make(const SolverContext& context, const VectorX& u);

  /// Whether the objective changes as soon as the rows below do not vanish: not so for means, and for sums, of which
  /// one figure may make up for another.
  bool is_complete() const;
  /// Rows over the parameters that vanish for changes with which no figure changes: the samples at which a peak or a
  /// maximum is reached, all samples of other statistics.
  const MatrixX& constant_parameter_rows() const { return constant_rows_; }
  /// The figures at u as maxima of smooth functions of the unit coordinates; std::nullopt if some are not.
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& u) const;
  /// The parameters at the design.
  const VectorX& parameters() const { return parameters_; }
  /// How far each sample exceeds its peak at the design, relative to the peak; zero if it does not.
  /// @param slopes of the features by the unit coordinates
  void evaluate_excess(const VectorX& features, const MatrixX* slopes, VectorX& excess, MatrixX* jacobian) const;
  /// Adds to a program over z, with unit coordinates centre + basis · z, the tangents of the peaks that a trial
  /// increases. @return whether there are any
  bool add_cuts(const VectorX& trial, const VectorX& centre, const MatrixX& basis,
                numerics::LinearProgram& program) const;

 private:
  FigureFace(const SolverContext& context, const VectorX& u, std::vector<AffineFigure> figures);
  MatrixX find_constant_rows(const MatrixX& slopes) const;

  const SolverContext& context_;
  VectorX parameters_;  ///< all features, of which the parameters come first
  MatrixX constant_rows_;
  std::vector<AffineFigure> figures_;
};

/// Orthonormal directions over `numbers`, which change masses but not the geometry, in which neither a condition nor the
/// objective changes.
/// @param objective nullptr: no number has an effect on it
/// @param face of the objective at the geometry of u; nullptr: unknown
/// @param conditions at the geometry of u
MatrixX find_flat_mass_directions(const SolverContext& context, const ScaledObjective* objective,
                                  const FigureFace* face, const Conditions& conditions, const VectorX& u,
                                  const std::vector<int>& numbers);

/// Dimension of the set of solutions near u: the null space of the conditions' Jacobian, restricted by the bounds and
/// physical limits active at u. With an objective, also the dimension of the set of optimal solutions, which excludes
/// directions along which the objective has slope or curvature.
/// @param objective nullptr: no objective
/// @param conditions at u
SolutionSet analyse_solution_set(const SolverContext& context, const ScaledObjective* objective,
                                 const Conditions& conditions, const VectorX& u);

// Optimality claims of a design.

/// What the search optimised.
enum class SearchTarget {
  nothing,    ///< any solution of the conditions
  residual,   ///< the sum of squared residuals
  objective,  ///< the objective
};

/// Sets the optimality and the summary of the search.
/// @param proved whether value and lower bound agree
void assess_optimality(const SolverContext& context, SearchTarget target, bool proved, DesignOutcome& outcome);

/// Relative tolerance for a figure above its bound: round-off of the convex relaxation.
inline constexpr double relative_gap_tolerance = 1e-6;

/// Raises the lower bound of a design's objective; if that closes the gap, the design is proved optimal.
void raise_lower_bound(DesignOutcome& outcome, double lower_bound);

/// Message for `reason` if no design has a value of the objective.
std::string undefined_objective_reason(const Objective& objective, const std::string& where,
                                       const std::string& failure_reason);

/// "peak(torque) <= 12 is missed by 3.2 % of its bound": the limit with the largest violation.
std::string describe_worst_limit(const std::vector<DesignLimit>& limits, const std::vector<LimitOutcome>& outcomes);

}  // namespace balance::design
