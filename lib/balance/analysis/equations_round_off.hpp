#pragma once
/// Entries of equations of motion that are nothing but round-off become 0. Private to analysis.

#include "balance/equations/equation_terms.hpp"

#include <vector>

namespace balance {

/// What entries of a mechanism's equations are measured by.
struct EquationSizes {
  double length;   ///< characteristic [m]
  double weight;   ///< of everything that moves times that length [N m]
  double springs;  ///< that turn by a radian, or stretch by that length [N m]
  double loads;    ///< at that length [N m]
};

EquationSizes equation_sizes(const Mechanism& mechanism);

/// @param lengths per row: whether its coordinate is a length
void clear_round_off(const EquationSizes& sizes, const std::vector<bool>& lengths, IndependentTerms& terms);
void clear_round_off(const EquationSizes& sizes, const std::vector<bool>& lengths, RedundantTerms& terms);
void clear_round_off(const EquationSizes& sizes, SpeedTerms& terms);
/// @param forces per actuator: whether its effort is a force
void clear_round_off(const EquationSizes& sizes, const std::vector<bool>& forces, EffortSplit& split);

/// Entries far below the largest one.
void clear_below_largest(MatrixX& matrix);

}  // namespace balance
