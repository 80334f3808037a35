#pragma once
/// How close to a singular configuration results can be trusted.

#include <array>

namespace balance::numerics {

/// Threshold on the smallest pivot, for entries scaled to order one. At a distance ε from a singular configuration,
/// pivots are of order ε; round-off leaves positions uncertain by 1e-16 / ε, and hence the directions of the equations
/// by 1e-16 / ε²: here, 1e-5.
inline constexpr double singular_pivot_threshold = 3e-6;

/// Smallest pivot below which a motion is reported as near a singularity: rates and forces are of the order of its
/// reciprocal and have a relative uncertainty of 1e-10 from round-off.
inline constexpr double near_singular_pivot_threshold = 1e-3;

/// Limits on the change of a matrix in a step. Their sum is below 1, so that it stays regular in between
/// (docs/theory.md, section 2).
inline constexpr double max_matrix_change = 0.7;     ///< along the straight line
inline constexpr double max_matrix_curvature = 0.2;  ///< deviation of the path from the straight line

/// Extrapolates the decrease of a monitored matrix's smallest pivot along a motion.
class PivotExtrapolation {
 public:
  void add_sample(double pivot, double time) {
    if (pivot < min_pivot_) min_pivot_ = pivot, min_pivot_time_ = time;
    if (pivot < reliable_pivot_threshold) return;
    samples_[0] = samples_[1];
    samples_[1] = samples_[2];
    samples_[2] = {pivot, time};
  }

  /// Time at which the pivot vanishes, extrapolated as a power of the remaining time: 1/2 (the path leaves the
  /// workspace), 1 (crossed) or 2 (touched).
  /// @param detected_time a time at which it has nearly vanished: the result if the last samples follow none of these
  /// powers
  double extrapolate_zero(double detected_time) const;

 private:
  struct PivotSample {
    double pivot = 0, time = 0;
  };

  /// Below it, the pivot is affected by round-off in the configuration.
  static constexpr double reliable_pivot_threshold = 1e-5;

  std::array<PivotSample, 3> samples_;
  double min_pivot_ = near_singular_pivot_threshold, min_pivot_time_ = 0;  ///< the smallest pivot so far
};

}  // namespace balance::numerics
