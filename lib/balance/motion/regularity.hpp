#pragma once
/// How near to a singular configuration results can still be trusted. Private to motion, dynamics and control.

namespace balance {

/// Smallest pivot of entries scaled to the order of one. At a distance ε from a singular configuration pivots are of the order
/// ε, round-off leaves positions 1e-16 / ε uncertain and with them the directions of the equations 1e-16 / ε²: here, 1e-5.
inline constexpr double singular_pivot_threshold = 3e-6;

/// Smallest pivot below which a motion is told to come near a singularity: rates and forces are of the order of its reciprocal, and
/// round-off leaves 1e-10 of them uncertain.
inline constexpr double near_singular_pivot_threshold = 1e-3;

/// What a step may change of a matrix: less than 1 together, so that it stays regular in between (docs/theory.md, section 2).
inline constexpr double max_matrix_change = 0.7;     ///< along the straight way
inline constexpr double max_matrix_curvature = 0.2;  ///< how far the way may lie off the straight one

}  // namespace balance
