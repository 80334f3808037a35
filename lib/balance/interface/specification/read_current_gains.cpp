// Gains of the actuators' motors: the effort of a current.

#include "balance/interface/specification/study_builder.hpp"

#include <string>
#include <vector>

namespace balance::specification {

void read_current_gains(const SpecCursor& section, StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  const bool is_uncertain =
      mechanism.actuators.empty() ? draft.problems.is_uncertain("actuators") : draft.problems.is_invalid("actuators");
  if (is_uncertain) throw CascadingError();
  if (mechanism.actuators.empty())
    section.fail({.expected = "'actuators', whose motors have gains", .found = "a spec without them"});
  std::vector<std::string> names;
  for (const CoordinateId c : mechanism.actuators)
    names.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
  const std::string expected = "a mapping of actuators to the effort of one ampere";
  read_entry_per_name(section, names, Presence::optional, expected, expected, [&](const SpecCursor& at, std::size_t a) {
    const CoordinateId c = mechanism.actuators[a];
    const bool is_angle = mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::angle;
    draft.study.current_gains.emplace_back(
        c, read_number(at, draft, is_angle ? dimension::moment : dimension::force, SignConstraint::positive).value());
  });
}

}  // namespace balance::specification
