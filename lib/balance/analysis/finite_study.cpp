#include "balance/analysis/finite_study.hpp"

#include "balance/base/error.hpp"
#include "balance/design/features.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance {

Study finite_study(const std::function<Study(const VectorX& x)>& at, const VectorX& x) {
  Study study = at(x);
  const Mechanism& m = study.mechanism;
  const bool finite = designing::features(m, {}).allFinite() && designing::geometry(m, {}).allFinite() &&
                      std::all_of(m.assembly.begin(), m.assembly.end(),
                                  [](const CoordinateValue& given) { return std::isfinite(given.value); });
  if (finite) return study;
  Mistake mistake;
  mistake.message = "an expression of the spec has no value with these numbers";
  throw SpecError(std::move(mistake));
}

}  // namespace balance
