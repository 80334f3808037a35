#pragma once
/// A planar mechanism's equations in natural coordinates as formulas: constant mass matrix, quadratic constraints with
/// their Jacobian, the matrices C_P. Source: P3 eq. 1–46 as corrected.

#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

/// A complex number represents the 2×2 matrix [re −im; im re] that multiplies (x, y) of a point.
struct Complex {
  Polynomial re, im;
};

/// For p points, the moving ones first; the unknowns are x and y of the moving points.
struct NaturalEquations {
  std::vector<std::string> points;                  ///< "crank1.B"
  std::vector<int> unknowns;                        ///< symbols: x and y of the first point, …
  std::vector<std::vector<Complex>> mass;           ///< p×p [kg], Hermitian: kinetic energy ½ żᴴ M ż
  std::vector<Complex> coefficients;                ///< C_P of every point [kg]
  Row constraint;                                   ///< Φ = 0, at most quadratic
  Matrix jacobian;                                  ///< with respect to the unknowns
  std::vector<std::pair<int, Polynomial>> aliases;  ///< symbols for sums that are divisors
};

/// @throws FormulaError for anything that has no formula
NaturalEquations derive_natural_equations(Ring& ring, const BasicPointModel& model);

}  // namespace balance::formulas
