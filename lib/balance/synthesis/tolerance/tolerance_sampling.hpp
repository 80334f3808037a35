#pragma once
/// Figures of mechanisms whose numbers are drawn at random: a check of what tolerance() says to first order, and an answer where that has
/// none. The same seed draws the same numbers everywhere.

#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace balance {

/// Random values of numbers that may be off, the same with every standard library.
class ToleranceSampler {
 public:
  explicit ToleranceSampler(std::uint64_t seed) : generator_(seed) {}

  /// By how much the number is off.
  double draw(const TolerancedParameter& number) { return draw(number.distribution, number.width); }
  /// The same of a number whose deviation is 1.
  double draw_standard(Distribution spread) {
    return draw(spread, spread == Distribution::uniform ? std::numbers::sqrt3 : 1);
  }

 private:
  double draw(Distribution spread, double width) {
    if (spread == Distribution::uniform) return width * (2 * draw_uniform() - 1);
    // Box and Muller; the second of the pair is left.
    const double radius = std::sqrt(-2 * elementary::log1p(-draw_uniform()));
    return width * radius * elementary::cos(2 * std::numbers::pi * draw_uniform());
  }

  /// In [0, 1).
  double draw_uniform() { return static_cast<double>(generator_() >> 11) * 0x1p-53; }

  std::mt19937_64 generator_;
};

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
