#pragma once
/// Adaptive balancing: adjustable numbers as functions of the load.

#include "balance/synthesis/design/design_problem.hpp"

#include <optional>
#include <vector>

namespace balance::design {

/// a(p), polynomials of the load variables p.
struct AdaptiveLaw {
  struct Term {
    std::vector<int> powers;  ///< of each load variable
    VectorX coefficients;     ///< of each adapted variable [SI, parameters as written]
  };
  std::vector<Term> terms;  ///< sorted by degree; the constant comes first

  /// @param loads p [SI, parameters as written] @return a
  VectorX evaluate(const VectorX& loads) const;
  /// da/dp: adapted variables × load variables.
  MatrixX jacobian(const VectorX& loads) const;
  /// Whether adapted variable i is an affine function of the load variables.
  bool is_affine(Eigen::Index i) const;
};

/// The law under which all conditions hold for every load, provided that they have the form A a + b(p) = 0 with a
/// constant A. Directions that A leaves undetermined keep their values in `anchor`. Bounds are ignored.
/// @param problem must have goals; its variables are the adapted ones followed by those of the load
/// @param anchor values of the adapted variables
/// @return std::nullopt if the conditions are of another form or do not hold for all loads
/// Source: P0 section 3.2, eq. 95; docs/theory.md section 6.
std::optional<AdaptiveLaw> find_adaptive_law(const DesignProblem& problem, const VectorX& anchor);

}  // namespace balance::design
