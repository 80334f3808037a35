#include "balance/analysis/finite_trial.hpp"

#include "balance/base/error.hpp"
#include "balance/design/features.hpp"
#include "balance/model/validate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance {

Trial finite_trial(const DesignSpace& space, const VectorX& x) {
  Trial trial = space.trial(x);
  const Mechanism& m = trial.mechanism;
  const auto fail = [&](const char* message) {
    throw SpecError({.place = {.file = space.start.spec_file}, .message = message});
  };
  const bool finite = designing::features(m, {}).allFinite() && designing::geometry(m, {}).allFinite() &&
                      std::all_of(m.assembly.begin(), m.assembly.end(),
                                  [](const CoordinateValue& given) { return std::isfinite(given.value); });
  if (!finite) fail("an expression of the spec has no value with these numbers");
  if (std::any_of(m.friction.begin(), m.friction.end(), [](const Friction& friction) {
        return friction.static_limit(1) < friction.dry(1) || friction.static_limit(-1) < friction.dry(-1);
      }))
    fail("static friction is less than dry friction with these numbers");
  return trial;
}

std::string first_fault(const Mechanism& mechanism) {
  const std::vector<Fault> faults = validate(mechanism);
  return faults.empty() ? "" : faults.front().sentence;
}

}  // namespace balance
