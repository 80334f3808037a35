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

/// Relative change of a number on its way through the text: a unit's factor, or the law of
/// an adapted number, rounds it.
constexpr double relative_value_tolerance = 1e-9;
/// Relative to the largest number of its kind; smaller numbers are round-off of cancellation.
constexpr double cancellation_tolerance = 1e-12;

bool is_equal_within_tolerance(const VectorX& read, const VectorX& designed) {
  if (read.size() != designed.size()) return false;
  const VectorX magnitude = read.cwiseAbs().cwiseMax(designed.cwiseAbs());
  const double absolute_tolerance = cancellation_tolerance * max_abs(magnitude);
  return ((read - designed).cwiseAbs().array() <= relative_value_tolerance * magnitude.array() + absolute_tolerance)
      .all();
}

/// How the study that was read differs from the designed one; empty: not at all.
std::string find_difference(const Study& read, const Study& designed) {
  const auto numbers = [](const Study& study) { return design::compute_features(study.mechanism, {}); };
  const auto lengths = [](const Study& study) { return design::collect_geometry(study.mechanism, {}); };
  if (!is_equal_within_tolerance(numbers(read), numbers(designed))) return "its masses are not those of the design";
  if (!is_equal_within_tolerance(lengths(read), lengths(designed))) return "its lengths are not those of the design";
  const bool has_same_durations = std::equal(
      read.trajectories.begin(), read.trajectories.end(), designed.trajectories.begin(), designed.trajectories.end(),
      [](const Trajectory& a, const Trajectory& b) {
        return a.name == b.name && std::abs(a.duration - b.duration) <= relative_value_tolerance * std::abs(b.duration);
      });
  return has_same_durations ? "" : "its motions are not those of the design";
}

}  // namespace

DesignedSpec format_designed_spec(const DesignSpace& space, const DesignReport& report) {
  const std::vector<std::string> laws = make_law_expressions(report);
  const std::vector<OptionalElementText> omitted_elements = list_omitted_elements(report);
  DesignedSpec spec{format_balanced_spec(space.start, report.outcome.x, laws), {}};
  try {
    if (const std::string difference = find_difference(read_spec(spec.text, space.start.spec_file), report.study_after);
        !difference.empty())
      spec.refusal = {"not-reproduced", "the spec of the design does not reproduce it: " + difference};
  } catch (const SpecError& error) {
    spec.refusal = {"not-readable", "the spec of the design cannot be read: " + error.summary()};
  }
  if (spec.refusal || omitted_elements.empty()) return spec;
  const std::string reduced_text = format_balanced_spec(space.start, report.outcome.x, laws, omitted_elements);
  try {
    read_spec(reduced_text, space.start.spec_file);
    spec.text = reduced_text;
  } catch (const SpecError&) {
    // something else refers to an element that is left out
  }
  return spec;
}

}  // namespace balance
