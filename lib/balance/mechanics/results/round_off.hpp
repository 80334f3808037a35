#pragma once
/// Which values of a run are round-off: no larger than a few hundred units in the last place of the terms that they are the sum
/// of (mechanics/results/term_magnitudes.hpp), over the mobility where that is below one.

#include "balance/mechanics/results/result.hpp"

#include <cmath>

namespace balance {

/// Takes both of a run's sizes over.
/// @param terms largest sizes
/// @param grown largest sizes over the mobility
void set_round_off(RunResult& result, const TermMagnitudes& terms, const TermMagnitudes& grown);

/// One number per label of an array's columns, or a single one; null for arrays that have none.
VectorX TermMagnitudes::*term_magnitude_of(Samples RunResult::*array);

/// Of one column of one of the result's arrays, in its unit; 0 where nothing is known.
/// @param sizes the result's `term_sizes` or its `round_off`
double column_term_magnitude(const RunResult& result, const TermMagnitudes& sizes, Samples RunResult::*array,
                             Eigen::Index column);

/// The same of its `round_off`.
double column_round_off(const RunResult& result, Samples RunResult::*array, Eigen::Index column);

/// The value, or 0 if it is round-off.
inline double suppress_round_off(double round_off, double value) {
  return std::abs(value) <= round_off && std::isfinite(round_off) ? 0 : value;
}

/// A column none of whose values is more than round-off becomes 0.
void clear_column(Samples& values, Eigen::Index column, double round_off);

/// An array with 0 in the place of round-off.
Samples suppress_round_off(const RunResult& result, Samples RunResult::*array);

/// Columns of the array that are nothing but round-off become 0. What they are the small sum of is known: near a singularity, where errors
/// grow, columns above 1e-9 of that are left alone.
void clear_round_off(Samples RunResult::*array, RunResult& result);
/// The same of all arrays.
void clear_round_off(RunResult& result);

}  // namespace balance
