#pragma once
/// A spec as a function of its free numbers.

#include "balance/motion/study/spec_expressions.hpp"
#include "balance/motion/study/study.hpp"

#include <memory>

namespace balance {

/// Mechanism and trajectories for one set of free numbers.
struct DesignInstance {
  Mechanism mechanism;
  std::vector<Trajectory> trajectories;
};

struct DesignSpace {
  Study start;  ///< at the start values, complete and validated
  std::shared_ptr<const Recording> recording;
  std::vector<double> inputs;    ///< values of the recording's inputs; those of free numbers are replaced
  std::vector<int> free_inputs;  ///< the input of each of start.free_numbers

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
  /// The space in which only the numbers `free_indices` are free and the others are fixed at x.
  DesignSpace fix_others(const VectorX& x, const std::vector<int>& free_indices) const;
};

}  // namespace balance
