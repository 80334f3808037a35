#include "balance/timing/stated_limits.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {
namespace {

void check_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  for (const MotionLimit& limit : trajectory.limits) {
    const double least = limit.least.value_or(-limit.bound);
    if (!(least < limit.bound) || !std::isfinite(least) || !std::isfinite(limit.bound))
      throw std::invalid_argument(
          "the limit of " + limit.quantity +
          (limit.least ? " must have a least value below the largest one" : " must be positive"));
  }
  if (!trajectory.limits.empty()) refuse_changing_loads(mechanism, "what limits leave");
}

}  // namespace

std::vector<LimitedQuantity> find_or_throw(const Mechanism& mechanism, const std::string& name) {
  std::vector<LimitedQuantity> found = find_limited(mechanism, name);
  if (found.empty()) throw std::invalid_argument("no law of motion can limit '" + name + "' of this mechanism");
  return found;
}

void refuse_changing_loads(const Mechanism& mechanism, const std::string& what) {
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 1; k < load.force.size(); ++k)
      if (load.force[k] != load.force[0] || load.moment[k] != load.moment[0])
        throw std::invalid_argument(what + " cannot be found under the load " + load.name +
                                    ", which changes with time");
}

StatedLimits list_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  check_limits(mechanism, trajectory);
  StatedLimits all;
  for (const MotionLimit& limit : trajectory.limits)
    for (const LimitedQuantity& quantity : find_or_throw(mechanism, limit.quantity)) {
      if (limit.least && quantity.count > 1)
        throw std::invalid_argument("the magnitude of " + quantity.name + " has no least value: limit a component");
      const double least = limit.least.value_or(-limit.bound);
      all.quantities.push_back(quantity);
      all.bounds.push_back((limit.bound - least) / 2);
      all.middles.push_back((limit.bound + least) / 2);
    }
  return all;
}

PathModel model_limits(const Mechanism& mechanism, const Trajectory& trajectory, const StatedLimits& limits) {
  PathModel model = model_path(mechanism, trajectory, limits.quantities);
  for (std::size_t r = 0; r < std::min(model.rows.size(), limits.middles.size()); ++r)
    model.rows[r].middle = limits.middles[r];
  return model;
}

}  // namespace balance
