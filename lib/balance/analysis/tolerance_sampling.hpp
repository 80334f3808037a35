#pragma once
/// Figures of mechanisms whose numbers are drawn at random: a check of what tolerance() says to first order, and an answer where that has
/// none. The same seed draws the same numbers everywhere.

#include "balance/result/figure.hpp"
#include "balance/study/design_space.hpp"
#include "balance/study/tolerances.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace balance {

/// More are likelier a misprint than a wish.
inline constexpr long max_tolerance_draws = 1'000'000;

struct MonteCarloOptions {
  long count = 1000;
  std::uint64_t seed = 1;
};

struct SampledFigure {
  std::string quantity, unit;
  Statistic figure = Statistic::rms;
  double mean = 0, deviation = 0;
  double mean_error = 0, deviation_error = 0;  ///< standard errors of both; the second by the draws' own fourth moment
  std::array<double, 3> quantiles{};           ///< 5, 50 and 95 %
};

struct MonteCarloReport {
  long run_count = 0;                      ///< mechanisms that ran
  std::map<std::string, long> rejections;  ///< by reason, how many draws are no mechanism or cannot move so
  std::vector<SampledFigure>
      figures;  ///< of every metric peak, rms, mean and range; empty if fewer than two mechanisms ran
};

/// @param quantities as for tolerance() @param progress told now and then which part is done, 0 to 1
/// @throws std::invalid_argument if there are fewer than two draws
MonteCarloReport sample_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities, const MonteCarloOptions& draws,
                                  const std::function<void(double part)>& progress = {});

}  // namespace balance
