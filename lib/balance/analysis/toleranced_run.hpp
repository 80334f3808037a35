#pragma once
/// A run with what every number that may be off changes it by. Private to analysis.

#include "balance/analysis/number_opening.hpp"
#include "balance/gradients/motion_gradient.hpp"
#include "balance/result/tracks.hpp"
#include "balance/study/design_space.hpp"
#include "balance/study/tolerances.hpp"

#include <string>
#include <vector>

namespace balance {

/// One row of the run or of what lies between its samples, and its part of the duration.
struct ToleranceSample {
  bool is_intermediate = false;
  long row = 0;
  double time = 0;
  double weight = 0;
};

class TolerancedRun {
 public:
  /// @param space its inputs are taken as they are @param numbers off by as much as they say
  /// @param quantities as in tolerance()
  /// @throws std::invalid_argument if there are no numbers or too many samples, or a trajectory whose law is searched for
  TolerancedRun(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                const std::vector<std::string>& quantities);

  const MotionOutcome& outcome() const { return run().outcome; }
  // What follows is there if the run is done.
  const RunResult& run() const { return gradients_.back().run; }
  const std::vector<ToleranceSample>& samples() const { return places_; }
  /// dual_width numbers each.
  const std::vector<FigureGradients>& figures() const { return figures_; }
  /// Those of numbers that open a joint are 0.
  const VectorX& deviations() const { return sigma_; }
  const std::vector<IncompatibleParameter>& incompatible_parameters() const { return incompatible_parameters_; }

  const RunResult& derivative(Eigen::Index number, bool between) const;
  VectorX value(const MetricSeries& track, const ToleranceSample& place) const;
  /// A row per number: what its deviation changes the track's components by.
  MatrixX contributions(const MetricSeries& track, const ToleranceSample& place) const;

 private:
  VectorX sigma_;
  std::vector<RunGradient> gradients_;  ///< dual_width numbers each
  std::vector<FigureGradients> figures_;
  std::vector<IncompatibleParameter> incompatible_parameters_;
  std::vector<ToleranceSample> places_;
};

/// Fourth moment over the squared second one, less that of a normal distribution.
double excess_kurtosis(Distribution spread);

}  // namespace balance
