#pragma once
/// The quantities that a law of motion can be made to limit: those that are affine in s'' and s'² (or linear in s') at a place of a
/// path. See docs/motion.md.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <string>
#include <vector>

namespace balance {

/// A scalar, or a vector whose magnitude is meant.
struct LimitableQuantity {
  /// How it depends on the motion along a path.
  enum class Kind {
    force,              ///< a s'' + b s'² + c, and friction's part in s'
    rate,               ///< d s'
    energy,             ///< b s'²
    tool_velocity,      ///< d s' with d = dp/ds of the tool's position
    tool_acceleration,  ///< a s'' + b s'² with a = dp/ds, b = d²p/ds²
  };

  std::string name;  ///< "torque[A1]", "shaking_force", "shaking_force[x]"
  std::string unit;  ///< SI: "N m", "rad/s"
  Kind kind = Kind::force;
  const double* (*values)(const Sample&) = nullptr;
  int first = 0, count = 1;  ///< of those values
};

/// What a name stands for: one quantity, or all that share it ("torque": every actuator's, if their units are alike).
/// Empty if there is no such quantity.
std::vector<LimitableQuantity> find_limitable_quantities(const Mechanism& mechanism, const std::string& name);

/// Every name that find_limitable_quantities() knows of a mechanism, the shared ones before those that share them.
std::vector<std::string> list_limitable_names(const Mechanism& mechanism);

}  // namespace balance
