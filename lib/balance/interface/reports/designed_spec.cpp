#include "balance/interface/reports/designed_spec.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/load_case_sections.hpp"
#include "balance/interface/specification/balanced_spec.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/design/geometry_features.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Part of a number by which it may change on its way through the text: a unit's factor, or the law of an adapted number, rounds it.
constexpr double relative_value_tolerance = 1e-9;
/// Part of the largest number of its kind below which a number is what cancels.
constexpr double cancellation_tolerance = 1e-12;

bool is_equal_within_tolerance(const VectorX& read, const VectorX& designed) {
  if (read.size() != designed.size()) return false;
  const VectorX size = read.cwiseAbs().cwiseMax(designed.cwiseAbs());
  const double least = cancellation_tolerance * max_abs(size);
  return ((read - designed).cwiseAbs().array() <= relative_value_tolerance * size.array() + least).all();
}

/// What the study that was read differs in; empty: nothing.
std::string find_difference(const Study& read, const Study& designed) {
  const auto numbers = [](const Study& study) { return design::compute_features(study.mechanism, {}); };
  const auto lengths = [](const Study& study) { return design::collect_geometry(study.mechanism, {}); };
  if (!is_equal_within_tolerance(numbers(read), numbers(designed))) return "its masses are not those of the design";
  if (!is_equal_within_tolerance(lengths(read), lengths(designed))) return "its lengths are not those of the design";
  const bool in_time = std::equal(read.trajectories.begin(), read.trajectories.end(), designed.trajectories.begin(),
                                  designed.trajectories.end(), [](const Trajectory& a, const Trajectory& b) {
                                    return a.name == b.name && std::abs(a.duration - b.duration) <=
                                                                   relative_value_tolerance * std::abs(b.duration);
                                  });
  return in_time ? "" : "its motions are not those of the design";
}

}  // namespace

DesignedSpec format_designed_spec(const DesignSpace& space, const DesignReport& report) {
  const std::vector<std::string> laws = make_law_expressions(report);
  const std::vector<OptionalElementText> gaps = list_omitted_elements(report);
  DesignedSpec spec{format_balanced_spec(space.start, report.outcome.x, laws), {}};
  try {
    if (const std::string what = find_difference(read_spec(spec.text, space.start.spec_file), report.study_after);
        !what.empty())
      spec.refusal = {"not-reproduced", "the spec of the design does not give it back: " + what};
  } catch (const SpecError& error) {
    spec.refusal = {"not-readable", "the design is no spec that could be read: " + error.summary()};
  }
  if (spec.refusal || gaps.empty()) return spec;
  const std::string without = format_balanced_spec(space.start, report.outcome.x, laws, gaps);
  try {
    read_spec(without, space.start.spec_file);
    spec.text = without;
  } catch (const SpecError&) {
    // something else names what is left out
  }
  return spec;
}

}  // namespace balance
