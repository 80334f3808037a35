#pragma once
/// A run with its derivatives with respect to the toleranced numbers.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace balance::tolerance {

/// A spec's mechanism and trajectories with derivatives with respect to the toleranced numbers.
class TolerancedDuals {
 public:
  /// Differentiates with respect to the numbers [first, first + dual_width), or fewer at the end.
  /// @param space, numbers must outlive this object
  TolerancedDuals(const DesignSpace& space, const Tolerances& numbers, std::size_t first)
      : space_(space), values_(*space.recording, inputs(space, numbers, first)) {}

  MechanismOf<derivatives::DualNumber> mechanism() const {
    MechanismOf<derivatives::DualNumber> mechanism = values_.mechanism();
    if (space_.assembly_mode) study::set_assembly(mechanism, space_.start.mechanism.assembly);
    return mechanism;
  }
  /// @param trajectory one of the spec's, but possibly with another number of samples
  TrajectoryOf<derivatives::DualNumber> trajectory(const Trajectory& trajectory) const {
    const std::size_t index = trajectory_index(space_.start, trajectory.name);
    auto duals = trajectory::cast_scalar<derivatives::DualNumber>(space_.recording->trajectories.at(index), values_);
    duals.samples = trajectory.samples;
    return duals;
  }

 private:
  static std::vector<derivatives::DualNumber> inputs(const DesignSpace& space, const Tolerances& numbers,
                                                     std::size_t first) {
    std::vector<derivatives::DualNumber> dual_inputs(space.inputs.begin(), space.inputs.end());
    for (std::size_t i = first; i < std::min(numbers.size(), first + numerics::dual_width); ++i)
      dual_inputs[static_cast<std::size_t>(numbers[i].input)].d[i - first] = 1;
    return dual_inputs;
  }

  const DesignSpace& space_;
  study::RecordedValues<derivatives::DualNumber> values_;
};

/// One row of the run or of the rows between its samples, and its fraction of the duration.
struct ToleranceSample {
  bool is_intermediate = false;
  long row = 0;
  double time = 0;
  double weight = 0;
};

class TolerancedRun {
 public:
  /// @param space with its current inputs
  /// @param numbers with their deviations
  /// @param quantities as in analyse_tolerance
  /// @throws std::invalid_argument without numbers, with too many samples, or if the trajectory's law is to be
  /// optimised
  TolerancedRun(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                const std::vector<std::string>& quantities);

  const MotionOutcome& outcome() const { return run().outcome; }
  // Valid only if the run is done.
  const RunResult& run() const { return gradients_.back().run; }
  const std::vector<ToleranceSample>& samples() const { return samples_; }
  /// One entry per dual_width numbers.
  const std::vector<derivatives::FigureGradients>& figures() const { return figures_; }
  /// Standard deviations; 0 for numbers that open a joint.
  const VectorX& deviations() const { return deviations_; }
  const std::vector<IncompatibleParameter>& incompatible_parameters() const { return incompatible_parameters_; }

  const RunResult& derivative(Eigen::Index number, bool is_intermediate) const;
  VectorX value(const results::MetricSeries& series, const ToleranceSample& sample) const;
  /// One row per number: the change of the series' components by its deviation.
  MatrixX contributions(const results::MetricSeries& series, const ToleranceSample& sample) const;

 private:
  VectorX deviations_;
  std::vector<derivatives::RunGradient> gradients_;  ///< one entry per dual_width numbers
  std::vector<derivatives::FigureGradients> figures_;
  std::vector<IncompatibleParameter> incompatible_parameters_;
  std::vector<ToleranceSample> samples_;
};

/// Fourth moment over the squared second one, minus that of a normal distribution.
double excess_kurtosis(study::Distribution distribution);

}  // namespace balance::tolerance
