#pragma once
/// A spec with its free numbers still free.

#include "balance/motion/study/spec_expressions.hpp"
#include "balance/motion/study/study.hpp"

#include <memory>

namespace balance {

/// What a trial of a design looks at.
struct DesignInstance {
  Mechanism mechanism;
  std::vector<Trajectory> trajectories;
};

struct DesignSpace {
  Study start;  ///< at the start values, complete and validated
  std::shared_ptr<const Recording> recording;
  std::vector<double> inputs;    ///< of the recording; those of free numbers are replaced
  std::vector<int> free_inputs;  ///< per start.free_numbers: its input

  DesignSpace() = default;
  DesignSpace(Study study, std::shared_ptr<const Recording> recorded);

  /// The values that start.free_numbers start at.
  VectorX start_values() const;
  /// Mechanism and trajectories with other values of start.free_numbers (SI, in that order). Not checked for physical sense (a mass
  /// may be zero). A direction of no length is x, a quaternion of no length no rotation. Nothing is read for it.
  /// @throws std::invalid_argument for a vector of another length
  DesignInstance instantiate(const VectorX& x) const;
  /// The whole study; everything else is as when the spec was read.
  Study study_at(const VectorX& x) const;
  /// The mechanism over start.free_numbers.
  ParametricMechanism parametric() const;
  /// The space where only the numbers `kept` are free and the others stay at x.
  DesignSpace fix_others(const VectorX& x, const std::vector<int>& kept) const;
};

}  // namespace balance
