#pragma once
/// How near to a singular configuration results can still be trusted.

#include <array>

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

/// How the smallest pivot of a watched matrix goes down along a motion.
class PivotExtrapolation {
 public:
  void add_sample(double pivot, double time) {
    if (pivot < min_pivot_) min_pivot_ = pivot, min_pivot_time_ = time;
    if (pivot < reliable_pivot_threshold) return;
    samples_[0] = samples_[1];
    samples_[1] = samples_[2];
    samples_[2] = {pivot, time};
  }

  /// When the pivot vanishes, going on like a power of the time left: 1/2 (the way leaves the workspace), 1 (crossed) or 2 (touched).
  /// @param found a time at which it has nearly vanished: the answer where the last moments follow none of them
  double extrapolate_zero(double found) const;

 private:
  struct PivotSample {
    double pivot = 0, time = 0;
  };

  /// Below it, round-off in the configuration shows in the pivot.
  static constexpr double reliable_pivot_threshold = 1e-5;

  std::array<PivotSample, 3> samples_;
  double min_pivot_ = near_singular_pivot_threshold, min_pivot_time_ = 0;  ///< the smallest pivot so far
};

}  // namespace balance
