#pragma once
/// Figures of mechanisms whose numbers are drawn at random. They check the first-order results of analyse_tolerance,
/// and replace them where there are none. The same seed draws the same numbers everywhere.

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace balance::tolerance {

/// Random deviations of toleranced numbers, identical with every standard library.
class ToleranceSampler {
 public:
  explicit ToleranceSampler(std::uint64_t seed) : random_(seed) {}

  /// The deviation of the number.
  double draw(const study::TolerancedParameter& number) { return draw(number.distribution, number.width); }
  /// The same for a standard deviation of 1.
  double draw_standard(study::Distribution distribution) {
    return draw(distribution, distribution == study::Distribution::uniform ? std::numbers::sqrt3 : 1);
  }

 private:
  double draw(study::Distribution distribution, double width) {
    if (distribution == study::Distribution::uniform) return width * (2 * random_(0, 1) - 1);
    // Box–Muller; the second value of the pair is not used.
    const double radius = std::sqrt(-2 * elementary::log1p(-random_(0, 1)));
    return width * radius * elementary::cos(2 * std::numbers::pi * random_(0, 1));
  }

  numerics::UniformRandom random_;
};

/// Larger numbers are probably misprints.
inline constexpr long max_tolerance_draws = 1'000'000;

struct MonteCarloOptions {
  long count = 1000;
  std::uint64_t seed = 1;
};

struct SampledFigure {
  std::string quantity, unit;
  Statistic figure = Statistic::rms;
  double mean = 0, deviation = 0;
  double mean_error = 0, deviation_error = 0;  ///< standard errors; the second one from the draws' fourth moment
  std::array<double, 3> quantiles{};           ///< 5, 50 and 95 %
};

struct MonteCarloReport {
  long run_count = 0;                      ///< number of mechanisms that ran
  std::map<std::string, long> rejections;  ///< draws that are no valid mechanism or motion, by reason
  std::vector<SampledFigure>
      figures;  ///< peak, rms, mean and range of every metric; empty if fewer than two mechanisms ran
};

/// @param quantities as for analyse_tolerance
/// @param progress called from time to time with the completed fraction, 0 to 1
/// @throws std::invalid_argument if there are fewer than two draws
MonteCarloReport sample_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities, const MonteCarloOptions& options,
                                  const std::function<void(double fraction)>& progress = {});

}  // namespace balance::tolerance
