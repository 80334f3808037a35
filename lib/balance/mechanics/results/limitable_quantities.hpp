#pragma once
/// Quantities that a motion law can limit: those that are affine in s'' and s'² (or linear in s') at a point of a path.
/// See docs/motion.md.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <string>
#include <vector>

namespace balance::results {

/// A scalar, or a vector whose magnitude is limited.
struct LimitableQuantity {
  /// How the quantity depends on the motion along a path.
  enum class Kind {
    force,              ///< a s'' + b s'² + c, plus a friction term in s'
    rate,               ///< d s'
    energy,             ///< b s'²
    tool_velocity,      ///< d s' with d = dp/ds of the tool's position
    tool_acceleration,  ///< a s'' + b s'² with a = dp/ds, b = d²p/ds²
  };

  std::string name;  ///< "torque[A1]", "shaking_force", "shaking_force[x]"
  std::string unit;  ///< SI: "N m", "rad/s"
  Kind kind = Kind::force;
  const double* (*values)(const Sample&) = nullptr;
  int first = 0, count = 1;  ///< range within those values
};

/// The quantities that a name stands for: one, or all that share it ("torque": all actuators, if their units are
/// equal). Empty if there is none.
std::vector<LimitableQuantity> find_limitable_quantities(const Mechanism& mechanism, const std::string& name);

/// All names that find_limitable_quantities() knows for a mechanism; shared names come before those of their members.
std::vector<std::string> list_limitable_names(const Mechanism& mechanism);

}  // namespace balance::results
