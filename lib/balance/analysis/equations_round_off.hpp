#pragma once
/// Entries of equations of motion that are nothing but round-off become 0. Private to analysis.

#include "balance/equations/equation_terms.hpp"

#include <vector>

namespace balance {

/// What entries of a mechanism's equations are measured by.
struct EquationScales {
  double length;          ///< characteristic [m]
  double gravity_moment;  ///< of everything that moves times that length [N m]
  double spring_moment;   ///< that turn by a radian, or stretch by that length [N m]
  double load_moment;     ///< at that length [N m]
};

EquationScales compute_equation_scales(const Mechanism& mechanism);

/// @param lengths per row: whether its coordinate is a length
void clear_round_off(const EquationScales& sizes, const std::vector<bool>& lengths, IndependentTerms& terms);
void clear_round_off(const EquationScales& sizes, const std::vector<bool>& lengths, RedundantTerms& terms);
void clear_round_off(const EquationScales& sizes, SpeedTerms& terms);
/// @param forces per actuator: whether its effort is a force
void clear_round_off(const EquationScales& sizes, const std::vector<bool>& forces, EffortBreakdown& split);

/// Entries far below the largest one.
void clear_relative_round_off(MatrixX& matrix);

}  // namespace balance
