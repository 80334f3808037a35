#include "balance/timing/stated_limits.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {
namespace {

void check_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  for (const MotionLimit& limit : trajectory.limits) {
    const double least = limit.lower_bound.value_or(-limit.upper_bound);
    if (!(least < limit.upper_bound) || !std::isfinite(least) || !std::isfinite(limit.upper_bound))
      throw std::invalid_argument(
          "the limit of " + limit.quantity +
          (limit.lower_bound ? " must have a least value below the largest one" : " must be positive"));
  }
  if (!trajectory.limits.empty()) require_constant_loads(mechanism, "what limits leave");
}

}  // namespace

std::vector<LimitableQuantity> require_limited_quantities(const Mechanism& mechanism, const std::string& name) {
  std::vector<LimitableQuantity> found = find_limitable_quantities(mechanism, name);
  if (found.empty()) throw std::invalid_argument("no law of motion can limit '" + name + "' of this mechanism");
  return found;
}

void require_constant_loads(const Mechanism& mechanism, const std::string& what) {
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 1; k < load.force.size(); ++k)
      if (load.force[k] != load.force[0] || load.moment[k] != load.moment[0])
        throw std::invalid_argument(what + " cannot be found under the load " + load.name +
                                    ", which changes with time");
}

PathLimits collect_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  check_limits(mechanism, trajectory);
  PathLimits all;
  for (const MotionLimit& limit : trajectory.limits)
    for (const LimitableQuantity& quantity : require_limited_quantities(mechanism, limit.quantity)) {
      if (limit.lower_bound && quantity.count > 1)
        throw std::invalid_argument("the magnitude of " + quantity.name + " has no least value: limit a component");
      const double least = limit.lower_bound.value_or(-limit.upper_bound);
      all.quantities.push_back(quantity);
      all.half_widths.push_back((limit.upper_bound - least) / 2);
      all.centres.push_back((limit.upper_bound + least) / 2);
    }
  return all;
}

PathModel build_limited_path_model(const Mechanism& mechanism, const Trajectory& trajectory, const PathLimits& limits) {
  PathModel model = build_path_model(mechanism, trajectory, limits.quantities);
  for (std::size_t r = 0; r < std::min(model.rows.size(), limits.centres.size()); ++r)
    model.rows[r].centre = limits.centres[r];
  return model;
}

}  // namespace balance
