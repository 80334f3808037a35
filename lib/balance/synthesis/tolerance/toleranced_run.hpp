#pragma once
/// A run with what every number that may be off changes it by.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace balance {

/// A spec's mechanism and trajectories with derivatives by the numbers that may be off.
class TolerancedDuals {
 public:
  /// By numbers [first, first + dual_width), or as many as there are. @param space, numbers must outlive this
  TolerancedDuals(const DesignSpace& space, const Tolerances& numbers, std::size_t first)
      : space_(space), values_(*space.recording, inputs(space, numbers, first)) {}

  MechanismOf<DualNumber> mechanism() const { return values_.mechanism(); }
  /// @param trajectory one of the spec's, perhaps with samples of its own
  TrajectoryOf<DualNumber> trajectory(const Trajectory& trajectory) const {
    const auto& all = space_.start.trajectories;
    const auto same = [&](const Trajectory& one) { return one.name == trajectory.name; };
    const auto which = std::find_if(all.begin(), all.end(), same) - all.begin();
    auto duals = cast_scalar<DualNumber>(space_.recording->trajectories.at(static_cast<std::size_t>(which)), values_);
    duals.samples = trajectory.samples;
    return duals;
  }

 private:
  static std::vector<DualNumber> inputs(const DesignSpace& space, const Tolerances& numbers, std::size_t first) {
    std::vector<DualNumber> all(space.inputs.begin(), space.inputs.end());
    for (std::size_t i = first; i < std::min(numbers.size(), first + dual_width); ++i)
      all[static_cast<std::size_t>(numbers[i].input)].d[i - first] = 1;
    return all;
  }

  const DesignSpace& space_;
  RecordedValues<DualNumber> values_;
};

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
