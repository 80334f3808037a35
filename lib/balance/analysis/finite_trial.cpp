#include "balance/analysis/finite_trial.hpp"

#include "balance/base/error.hpp"
#include "balance/design/features.hpp"
#include "balance/model/validate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance {

DesignInstance instantiate_checked(const DesignSpace& space, const VectorX& x) {
  DesignInstance trial = space.instantiate(x);
  const Mechanism& m = trial.mechanism;
  const auto fail = [&](const char* message) {
    throw SpecError({.place = {.file = space.start.spec_file}, .message = message});
  };
  const bool finite = design::compute_features(m, {}).allFinite() && design::collect_geometry(m, {}).allFinite() &&
                      std::all_of(m.assembly.begin(), m.assembly.end(),
                                  [](const CoordinateValue& given) { return std::isfinite(given.value); });
  if (!finite) fail("an expression of the spec has no value with these numbers");
  if (std::any_of(m.friction.begin(), m.friction.end(), [](const Friction& friction) {
        return friction.static_limit(1) < friction.dry_friction(1) ||
               friction.static_limit(-1) < friction.dry_friction(-1);
      }))
    fail("static friction is less than dry friction with these numbers");
  return trial;
}

std::string find_validation_issue(const Mechanism& mechanism) {
  const std::vector<ValidationIssue> faults = validate(mechanism);
  return faults.empty() ? "" : faults.front().message;
}

}  // namespace balance
