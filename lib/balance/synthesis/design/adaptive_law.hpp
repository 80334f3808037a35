#pragma once
/// Adjustable numbers as functions of the load: adaptive balancing.

#include "balance/synthesis/design/design_problem.hpp"

#include <optional>
#include <vector>

namespace balance {

/// a(p), polynomials of the load's numbers p.
struct AdaptiveLaw {
  struct Term {
    std::vector<int> powers;  ///< per number of the load
    VectorX coefficients;     ///< per adapted number [SI, parameters as written]
  };
  std::vector<Term> terms;  ///< by degree; the constant first

  /// @param loads p [SI, parameters as written] @return a
  VectorX evaluate(const VectorX& loads) const;
  /// da/dp: adapted numbers × numbers of the load.
  MatrixX jacobian(const VectorX& loads) const;
  /// Adapted number i has no term but a constant and multiples of single loads.
  bool is_affine(Eigen::Index i) const;
};

/// The law for which all conditions hold whatever the load, where they are of the form A a + b(p) = 0 with a constant A. What A leaves
/// open stays as it is in `anchor`. Bounds are not looked at.
/// @param problem its variables are the adapted numbers, behind them the load's; it has goals
/// @param anchor values of the adapted numbers
/// @return nothing if the conditions are of another form, or do not hold for all loads
/// Source: P0 section 3.2, eq. 95; docs/theory.md section 6.
std::optional<AdaptiveLaw> find_adaptive_law(const DesignProblem& problem, const VectorX& anchor);

}  // namespace balance
