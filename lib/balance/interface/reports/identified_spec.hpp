#pragma once
/// The spec of an identified mechanism.

#include "balance/motion/study/study.hpp"
#include "balance/synthesis/identification/identification.hpp"

#include <string>
#include <vector>

namespace balance::reports {

struct IdentifiedSpec {
  std::string text;
  std::vector<std::string> notes;  ///< friction that was negative and is written as zero
};

/// The text that a study was read from with the masses, centres, inertias, rotors, friction and payloads that were found, and
/// with the deviations of the base parameters as `tolerances` of the numbers that they are named after. Comments and layout
/// are preserved. Reading it gives the identified mechanism, which is checked.
/// @throws SpecError if the spec's form does not allow it: bodies from parts, anchors, shapes
IdentifiedSpec format_identified_spec(const Study& study, const identification::Identification& found);

}  // namespace balance::reports
