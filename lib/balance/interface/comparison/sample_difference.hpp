#pragma once
/// Samples as a function of time between them.

#include "balance/foundation/base/types.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

// How far the samples of two runs are apart.

/// Whether their times can be compared as they are: durations differ by round-off only.
bool have_equal_durations(const RunResult& a, const RunResult& b);

/// [s]; 0 without samples.
double duration_of(const RunResult& result);

/// Of every quantity that both have with as many components. Behind them the worst of each that is several: "torque" of "torque[A1]", …,
/// by the largest of their figures.
std::vector<std::pair<std::string, Difference>> list_differences(const RunResult& base, const RunResult& other);

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

// The samples behind each metric of a run.

/// Columns of one of a RunResult's arrays that together are one quantity. Refers to the result, which must outlive it.
struct QuantitySeries {
  std::string quantity;  ///< as in RunResult::metrics: "torque[A1]", "shaking_force"; the worst of several is none
  const Samples* samples = nullptr;
  int first = 0, count = 1;  ///< columns
  double round_off = 0;      ///< of each of them (mechanics/results/round_off.hpp)
};

/// Quantities without samples are left out.
std::vector<QuantitySeries> list_series(const RunResult& result);

}  // namespace balance
