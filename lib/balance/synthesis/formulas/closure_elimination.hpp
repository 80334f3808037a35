#pragma once
/// The closures of loops, solved for the rates and accelerations of the dependent coordinates: in closed form where that
/// is short, otherwise in named steps, each of which uses only those before it.

#include "balance/synthesis/formulas/closed_poses.hpp"
#include "balance/synthesis/formulas/sheet_formula.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace balance::formulas {

/// Coordinates that were named as independent are not.
struct IndependentCoordinatesError : FormulaError {
  using FormulaError::FormulaError;
};

/// What the loops leave free at generic poses.
struct ClosureChoice {
  std::vector<int> independent;        ///< columns, ascending
  std::vector<std::size_t> dependent;  ///< the other columns
  std::vector<std::size_t> rows;       ///< as many independent closures
  std::vector<VectorX> poses;          ///< at which the loops close; empty without loops
};

/// Named coordinates, then the engine's independent ones where they are columns, then actuated columns, then others, as
/// far as they determine the motion.
/// @param names of coordinates; empty: a choice
/// @param jacobians of the closures at the poses
/// @throws FormulaError if there are no poses; IndependentCoordinatesError if the named coordinates do not determine the
/// motion, or are too many
ClosureChoice choose_independent_columns(const Mechanism& mechanism, const SymbolicTree& tree,
                                         const std::vector<std::string>& names, std::vector<VectorX> poses,
                                         std::vector<MatrixX> jacobians);
ClosureChoice choose_independent_columns(const Ring& ring, const Mechanism& mechanism,
                                         const SymbolicEquations& equations, const std::vector<std::string>& names);

/// @throws IndependentCoordinatesError if names of independent coordinates of a mechanism without loops, where all columns
/// are independent, are not those of all columns
void check_independent_without_loops(const Mechanism& mechanism, const SymbolicTree& tree,
                                     const std::vector<std::string>& names);

/// The mechanism with its joints alone: wheels may slip, and speeds are free.
Mechanism without_speed_constraints(Mechanism mechanism);

/// A divisor of the elimination and its size near the spec's rough values. It vanishes at singular poses, and may vanish at others.
struct EliminationPivot {
  Polynomial value;
  double size = 0;
};

/// ẏ = C q̇ and ÿ = C q̈ + Σ c_jk q̇_j q̇_k in the independent rates. Closures that share no unknowns are solved one after
/// the other.
class ClosureElimination {
 public:
  /// Solves for rates.
  /// @throws FormulaError if the closures cannot be solved, or only at too great a length
  ClosureElimination(Ring& ring, const SymbolicEquations& equations, ClosureChoice choice);
  ~ClosureElimination();
  ClosureElimination(const ClosureElimination&) = delete;
  ClosureElimination& operator=(const ClosureElimination&) = delete;

  const std::vector<int>& independent() const;
  /// At which the loops close, per column.
  const std::vector<VectorX>& poses() const;
  /// C: 0, 1, a single term, or a symbol that rate_steps() define.
  const Polynomial& rate(std::size_t column, std::size_t u) const;
  const std::vector<SheetFormula>& rate_steps() const;
  /// Whether rate_steps() contain no more than one determinant and C.
  bool is_closed_form() const;

  /// Solves for accelerations; call it once, before acceleration().
  void derive_accelerations();
  /// c_jk, likewise, with the steps that follow those of the rates.
  const Polynomial& acceleration(std::size_t column, std::size_t j, std::size_t k) const;
  const std::vector<SheetFormula>& acceleration_steps() const;

  /// Divisors other than determinants.
  const std::vector<EliminationPivot>& pivots() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Determinant by minors.
Polynomial determinant(const Matrix& A);
/// Of an entry, with its sign.
Polynomial cofactor(const Matrix& A, std::size_t row, std::size_t column);

/// Replaces sums of angles around a loop by the angle of the joint that closes it, if that is shorter.
Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p);

}  // namespace balance::formulas
