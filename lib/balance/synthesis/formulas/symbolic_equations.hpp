#pragma once
/// The equations of motion as formulas: M q̈ + D(q, q̇) + z = τ of the spanning tree, and the loop closures.

#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance::formulas {

using Row = std::vector<Polynomial>;
using Matrix = std::vector<Row>;

/// What to derive.
struct EquationSelection {
  bool inertia = true, velocity = true, gravity = true, closures = true;
};

/// In the n columns of the tree. τ are the efforts that the tree would need without its closures.
struct SymbolicEquations {
  SymbolicTree tree;
  Matrix M;               ///< n×n
  std::vector<Matrix> D;  ///< D[i][j][k], symmetric in j and k: Christoffel symbols; τᵢ contains D[i][j][k] q̇ⱼ q̇ₖ
  Row z;                  ///< weight and springs
  Row closure;            ///< h = 0
  Matrix A;               ///< its Jacobian
  Polynomial mass;        ///< of everything that moves
  Vector moment;          ///< first moment of everything, in world axes
  std::vector<std::pair<int, Polynomial>> lengths;  ///< symbol, square: of springs with a free length
};

/// @throws FormulaError for anything that has no formula or too long a one
SymbolicEquations derive_equations(Ring& ring, SymbolicTree tree, const EquationSelection& selection = {});

/// Derivative with respect to a column.
Polynomial column_derivative(const SymbolicTree& tree, const Polynomial& p, int column);

/// Number of terms in M (upper triangle), D (j ≤ k), z, A.
struct TermCount {
  std::size_t M = 0, D = 0, z = 0, A = 0;
};
TermCount count_terms(const SymbolicEquations& equations);

/// Polynomials for the recursions.
struct PolynomialFactory {
  Ring& ring;

  Polynomial convert(const Polynomial& p) const { return p; }
  Polynomial circular(int angle, bool sine) const { return Polynomial::of_angle(ring, angle, sine); }
  Polynomial symbol(int index) const { return Polynomial::of_symbol(ring, index); }
};

// The torques of a mechanism's tree as a matrix times inertial parameters.

/// τ = Y π + springs. Y contains the accelerations and rates of the columns as symbols.
struct SymbolicRegressor {
  std::vector<int> rates, accelerations;  ///< symbols, per column
  std::vector<int> parameters;            ///< symbols of π, in the order of list_parameters
  Matrix Y;                               ///< columns × parameters
};

/// @param equations of a tree with inertial parameters about the bodies' origins, in which they are linear
SymbolicRegressor derive_regressor(Ring& ring, const SymbolicEquations& equations);

/// `1 m1, 2 mx1, …`: the parameters of Y's columns.
std::string parameter_text(const Ring& ring, const SymbolicRegressor& regressor);

}  // namespace balance::formulas
