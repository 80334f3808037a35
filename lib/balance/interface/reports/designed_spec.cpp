#include "balance/interface/reports/designed_spec.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/load_case_sections.hpp"
#include "balance/interface/specification/balanced_spec.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/yaml_document.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/design/geometry_features.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace balance::reports {

namespace {

/// Relative change of a number on its way through the text: a unit's factor, or the law of
/// an adapted number, rounds it.
constexpr double relative_value_tolerance = 1e-9;
/// Relative to the largest number of its kind; smaller numbers are round-off of cancellation.
constexpr double cancellation_tolerance = 1e-12;

bool is_equal_within_tolerance(const VectorX& read, const VectorX& designed) {
  if (read.size() != designed.size()) return false;
  const VectorX magnitude = read.cwiseAbs().cwiseMax(designed.cwiseAbs());
  const double absolute_tolerance = cancellation_tolerance * numerics::max_abs(magnitude);
  return ((read - designed).cwiseAbs().array() <= relative_value_tolerance * magnitude.array() + absolute_tolerance)
      .all();
}

/// Whether two mechanisms begin their first trajectory in the same configuration, up to full turns of angles.
bool has_same_start(const Study& a, const Study& b) {
  const std::vector<CoordinateValue> p = simulation::start_coordinates(a), q = simulation::start_coordinates(b);
  if (p.size() != q.size()) return false;
  constexpr double configuration_tolerance = 1e-6;
  const double length = characteristic_length(a.mechanism);
  for (std::size_t c = 0; c < p.size(); ++c) {
    const bool is_angle = a.mechanism.coordinates[c].kind == CoordinateKind::angle;
    const double deviation =
        is_angle ? kinematics::unwrap_angle(p[c].value, q[c].value) - q[c].value : (p[c].value - q[c].value) / length;
    if (std::abs(deviation) > configuration_tolerance) return false;
  }
  return true;
}

/// How the study that was read differs from the designed one; empty: not at all.
std::string find_difference(const Study& read, const Study& designed) {
  const auto numbers = [](const Study& study) { return design::compute_features(study.mechanism, {}); };
  const auto lengths = [](const Study& study) { return design::collect_geometry(study.mechanism, {}); };
  if (!is_equal_within_tolerance(numbers(read), numbers(designed))) return "its masses are not those of the design";
  if (!is_equal_within_tolerance(lengths(read), lengths(designed))) return "its lengths are not those of the design";
  if (!has_same_start(read, designed)) return "it begins in another assembly mode than the design";
  const bool has_same_durations = std::equal(
      read.trajectories.begin(), read.trajectories.end(), designed.trajectories.begin(), designed.trajectories.end(),
      [](const Trajectory& a, const Trajectory& b) {
        return a.name == b.name && std::abs(a.duration - b.duration) <= relative_value_tolerance * std::abs(b.duration);
      });
  return has_same_durations ? "" : "its motions are not those of the design";
}

/// "assembly: {A: 1.6, B: -1.04}": the configuration in which the first trajectory begins, in the spec's units.
std::string assembly_line(const Study& study) {
  std::string line;
  for (const CoordinateValue& one : simulation::start_coordinates(study)) {
    const Coordinate& coordinate = study.mechanism.coordinates[static_cast<std::size_t>(one.coordinate)];
    const double unit =
        coordinate.kind == CoordinateKind::length ? study.mechanism.units.length : study.mechanism.units.angle;
    line += fmt::format("{}{}: {:.6g}", line.empty() ? "" : ", ", coordinate.name, one.value / unit + 0.0);
  }
  return "assembly: {" + line + "}\n";
}

/// The text with another top-level section `assembly`, which is added at the end if there is none.
std::string replace_assembly(const std::string& text, const std::string& line) {
  std::string result;
  bool is_inside = false, is_replaced = false;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const std::string_view one = std::string_view(text).substr(begin, end - begin);
    const bool begins_section = one.find_first_not_of(" \t}\r\n#") == 0;
    is_inside = one.starts_with("assembly:") || (is_inside && !begins_section);
    if (!is_inside) result += one;
    if (one.starts_with("assembly:") && !is_replaced) {
      result += line;
      is_replaced = true;
    }
    begin = end;
  }
  if (is_replaced) return result;
  return result + (result.empty() || result.back() == '\n' ? "" : "\n") + line;
}

/// With lengths as far from those of the spec as the design's, the values of `assembly` may select another mode.
/// @return the text with the design's own configuration, if it is needed
std::string select_designed_mode(const std::string& text, const DesignSpace& space, const DesignReport& report) {
  if (has_same_start(read_spec(text, space.start.spec_file), report.study_after)) return text;
  return replace_assembly(text, assembly_line(report.study_after));
}

}  // namespace

namespace {

/// The study whose text names the parts that were chosen.
Study name_chosen_parts(Study study, const DesignReport& report) {
  if (!report.catalogue) return study;
  for (std::size_t k = 0; k < study.catalogue_choices.size(); ++k) {
    const study::CatalogueChoice &before = study.catalogue_choices[k], &chosen = report.catalogue->choices[k];
    if (!before.is_free) continue;
    const auto row = static_cast<std::size_t>(chosen.row);
    study.rewrites.push_back(
        {before.begin, before.end,
         fmt::format("{{file: {}, part: {}, count: {}}}", specification::format_scalar(chosen.file->name),
                     specification::format_scalar(chosen.parts[row]), chosen.counts[row]),
         -1});
  }
  std::stable_sort(study.rewrites.begin(), study.rewrites.end(),
                   [](const auto& a, const auto& b) { return a.begin < b.begin; });
  return study;
}

}  // namespace

DesignedSpec format_designed_spec(const DesignSpace& space, const DesignReport& report) {
  const Study named = name_chosen_parts(space.start, report);
  const std::vector<std::string> laws = make_law_expressions(report);
  const std::vector<study::OptionalElementText> omitted_elements = list_omitted_elements(report);
  DesignedSpec spec{specification::format_balanced_spec(named, report.outcome.x, laws), {}};
  try {
    spec.text = select_designed_mode(spec.text, space, report);
    if (const std::string difference = find_difference(read_spec(spec.text, space.start.spec_file), report.study_after);
        !difference.empty())
      spec.refusal = {"not-reproduced", "the spec of the design does not reproduce it: " + difference};
  } catch (const SpecError& error) {
    spec.refusal = {"not-readable", "the spec of the design cannot be read: " + error.summary()};
  }
  if (spec.refusal || omitted_elements.empty()) return spec;
  try {
    const std::string reduced_text = select_designed_mode(
        specification::format_balanced_spec(named, report.outcome.x, laws, omitted_elements), space, report);
    read_spec(reduced_text, space.start.spec_file);
    spec.text = reduced_text;
  } catch (const SpecError&) {
    // something else refers to an element that is left out
  }
  return spec;
}

}  // namespace balance::reports
