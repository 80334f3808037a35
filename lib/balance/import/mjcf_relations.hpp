#pragma once
/// What MJCF says between bodies and joints that exist: closures, couplings, motors. Private to the reader of MJCF.

#include "balance/import/mjcf_source.hpp"
#include "balance/import/robot.hpp"

namespace balance::foreign {

/// `<equality>` (connect, weld, joint) and `<actuator>`.
void read_mjcf_relations(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& faults,
                         ForeignModel& robot);

}  // namespace balance::foreign
