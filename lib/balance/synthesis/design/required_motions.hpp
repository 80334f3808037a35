#pragma once
/// Motions that a design must be able to make.

#include "balance/motion/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance {

/// Those that do not depend on masses and can be followed to begin with. Where the mechanism cannot be assembled to begin with, all that
/// do not depend on masses.
class RequiredMotions {
 public:
  explicit RequiredMotions(const Study& start);

  /// Where the start is assembled; empty if it cannot be.
  const std::vector<CoordinateValue>& start_coordinates() const { return coordinates_; }
  /// The first motion that cannot be made, and why; empty: there is none.
  std::string infeasibility_reason(const DesignInstance& trial) const;

 private:
  std::vector<CoordinateValue> coordinates_;
  std::vector<std::string> motions_;
};

// Trials of designs whose expressions all have a value.

/// The first fault (validate) of a mechanism, a sentence; empty: there is none.
std::string find_validation_issue(const Mechanism& mechanism);

/// The mechanism and its trajectories at values of the free numbers.
/// @throws SpecError if an expression of the mechanism has no value there
DesignInstance instantiate_checked(const DesignSpace& space, const VectorX& x);

}  // namespace balance
