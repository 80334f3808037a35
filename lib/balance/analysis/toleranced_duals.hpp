#pragma once
/// A spec's mechanism and trajectories with derivatives by the numbers that may be off. Private to analysis.

#include "balance/gradients/over_duals.hpp"
#include "balance/study/design_space.hpp"
#include "balance/study/tolerances.hpp"

#include <algorithm>
#include <vector>

namespace balance {

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

}  // namespace balance
