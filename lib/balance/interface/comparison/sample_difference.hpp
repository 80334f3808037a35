#pragma once
/// Differences of the samples of two runs, and interpolation between samples.

#include "balance/foundation/base/types.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::comparison {

// Differences of the samples of two runs.

/// Whether times can be compared directly: the durations differ only by round-off.
bool have_equal_durations(const RunResult& a, const RunResult& b);

/// [s]; 0 without samples.
double duration_of(const RunResult& result);

/// Differences of every quantity that both runs have with the same number of components. They are followed by the worst
/// case of each quantity that has several entries: "torque" for "torque[A1]", …, with the maximum of each of their
/// figures.
std::vector<std::pair<std::string, Difference>> list_differences(const RunResult& base, const RunResult& other);

/// Interpolates through the four samples nearest to a time, but never across a jump: a step more than ten times as
/// steep as its neighbours. The samples do not determine where within that step the jump is.
class SampleInterpolant {
 public:
  /// @param time ascending
  /// @param samples one row per time; must outlive the interpolant
  /// @param first, count columns of the quantity
  SampleInterpolant(VectorX time, const Samples& samples, int first, int count);

  /// @return std::nullopt outside the samples and strictly within a step with a jump; the sample itself if its time
  /// differs by less than one part in 10^9 of the whole time
  std::optional<VectorX> evaluate(double time) const;

 private:
  VectorX row(Eigen::Index k) const;

  VectorX time_;
  const Samples& samples_;
  int first_, count_;
  std::vector<Eigen::Index>
      piece_begins_;  ///< first samples of the pieces without jumps, ascending, then the number of samples
};

// The samples behind each metric of a run.

/// Columns of an array of RunResult that together form one quantity. Refers to the result, which must outlive it.
struct QuantitySeries {
  std::string quantity;  ///< as in RunResult::metrics: "torque[A1]", "shaking_force"; excludes worst cases
  const Samples* samples = nullptr;
  int first = 0, count = 1;  ///< columns
  double round_off = 0;      ///< of each column (mechanics/results/round_off.hpp)
};

/// Omits quantities without samples.
std::vector<QuantitySeries> list_series(const RunResult& result);

}  // namespace balance::comparison
