#pragma once
/// Samples as a function of time between them.

#include "balance/base/types.hpp"

#include <optional>
#include <vector>

namespace balance {

/// Through the four samples nearest to a time, never across a jump: a step more than ten times as steep as those beside it. Where
/// within that step the jump is, samples do not tell.
class SampleInterpolant {
 public:
  /// @param time ascending
  /// @param samples one row per time; they must outlive the interpolant
  /// @param first, count the columns that are one quantity
  SampleInterpolant(VectorX time, const Samples& samples, int first, int count);

  /// @return nothing outside the samples and strictly within a step that jumps. At a sample, within one part in 10^9 of the whole
  ///         time, that sample itself.
  std::optional<VectorX> evaluate(double time) const;

 private:
  VectorX row(Eigen::Index k) const;
  void find_jumps();

  VectorX time_;
  const Samples& samples_;
  int first_, count_;
  std::vector<Eigen::Index>
      piece_begins_;  ///< first samples of the pieces without jumps, ascending, then the number of samples
};

}  // namespace balance
