#pragma once
/// A spec as a function of its free numbers.

#include "balance/motion/study/spec_expressions.hpp"
#include "balance/motion/study/study.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance::study {

/// Mechanism and trajectories for one set of free numbers.
struct DesignInstance {
  Mechanism mechanism;
  std::vector<Trajectory> trajectories;
  /// Why the assembly mode of the start values does not exist for these numbers; empty if it does, or is not followed.
  std::string mode_issue = {};
  /// Whether the assembly mode is another than that of the start values, which does not exist for these numbers.
  bool is_other_mode = false;
};

/// The assembly mode of a mechanism as a function of the numbers of its spec. Without it the mode is the one nearest to
/// the values of `assembly`, which may jump to another mode as lengths change.
class AssemblyModeSelector {
 public:
  virtual ~AssemblyModeSelector() = default;
  /// Sets the assembly values of the instance, or its mode_issue.
  /// @param inputs of the recording, from which the instance was made
  virtual void select(const std::vector<double>& inputs, DesignInstance& instance) const = 0;
};

struct DesignSpace {
  Study start;  ///< at the start values, complete and validated
  std::shared_ptr<const Recording> recording;
  std::vector<double> inputs;    ///< values of the recording's inputs; those of free numbers are replaced
  std::vector<int> free_inputs;  ///< the input of each of start.free_numbers
  std::shared_ptr<const AssemblyModeSelector> assembly_mode;  ///< nullptr: the mode nearest to the spec's `assembly`

  DesignSpace() = default;
  DesignSpace(Study study, std::shared_ptr<const Recording> recorded);

  /// Start values of start.free_numbers.
  VectorX start_values() const;
  /// Mechanism and trajectories for other values of start.free_numbers (SI, in that order). Physical validity is not
  /// checked (a mass may be zero). A direction of zero length becomes x, a quaternion of zero length no rotation. Does
  /// not read the spec again.
  /// @throws std::invalid_argument if the size of x is wrong
  DesignInstance instantiate(const VectorX& x) const;
  /// The whole study for these values; everything else is as read from the spec.
  Study study_at(const VectorX& x) const;
  /// The mechanism as a function of start.free_numbers.
  ParametricMechanism parametric() const;
  /// The space with these rows of the catalogues in start.catalogue_choices, none of which is free any more.
  DesignSpace with_rows(const std::vector<int>& rows) const;
  /// The space in which only the numbers `free_indices` are free and the others are fixed at x.
  DesignSpace fix_others(const VectorX& x, const std::vector<int>& free_indices) const;
};

/// Replaces the assembly values of a mechanism by others, without derivatives.
template <class T>
void set_assembly(MechanismOf<T>& mechanism, const std::vector<CoordinateValue>& values) {
  mechanism.assembly.clear();
  for (const CoordinateValue& one : values) mechanism.assembly.push_back({one.coordinate, T(one.value)});
}

}  // namespace balance::study

namespace balance {

using study::DesignSpace;

}  // namespace balance
