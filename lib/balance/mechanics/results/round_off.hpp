#pragma once
/// Decides which values of a run are round-off: those up to a few hundred units in the last place of the terms of their
/// sum (mechanics/results/term_magnitudes.hpp), divided by the mobility if that is below one.

#include "balance/mechanics/results/result.hpp"

#include <cmath>

namespace balance::results {

/// Sets term_magnitudes and round_off of a result.
/// @param terms largest magnitudes of terms
/// @param amplified largest magnitudes of terms, divided by the mobility
void set_round_off(RunResult& result, const TermMagnitudes& terms, const TermMagnitudes& amplified);

/// The member of TermMagnitudes for an array, with one number per owner of its columns or a single one; null if there
/// is none.
VectorX TermMagnitudes::*term_magnitude_of(Samples RunResult::*array);

/// Magnitude of the terms of one column of a result's array, in its unit; 0 if unknown.
/// @param magnitudes `term_magnitudes` or `round_off` of the result
double column_term_magnitude(const RunResult& result, const TermMagnitudes& magnitudes, Samples RunResult::*array,
                             Eigen::Index column);

/// The same for `round_off`.
double column_round_off(const RunResult& result, Samples RunResult::*array, Eigen::Index column);

/// The value, or 0 if it is round-off.
inline double suppress_round_off(double round_off, double value) {
  return std::abs(value) <= round_off && std::isfinite(round_off) ? 0 : value;
}

/// Sets a column to 0 if all of its values are round-off.
void clear_column(Samples& values, Eigen::Index column, double round_off);

/// A copy of an array with round-off set to 0.
Samples suppress_round_off(const RunResult& result, Samples RunResult::*array);

/// Sets columns that contain only round-off to 0. Near a singularity, where errors grow, columns above 1e-9 of the
/// known magnitudes of their terms are kept.
void clear_round_off(Samples RunResult::*array, RunResult& result);
/// The same for all arrays.
void clear_round_off(RunResult& result);

}  // namespace balance::results
