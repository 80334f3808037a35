#pragma once
/// Loops said inside a URDF. Private to the reader of URDF.

#include "balance/import/robot.hpp"
#include "balance/import/xml_document.hpp"

namespace balance::foreign {

/// `<loop>` and `<constraint>` with `<predecessor link>` and `<successor link>`, `<loop_joint>` with `<link1>` and `<link2>`, and
/// `<joint>` inside `<gazebo>`, whose frames follow from the model's zero pose.
/// @throws SpecError with everything that is wrong with them
void read_urdf_closures(const XmlDocument& document, ForeignModel& robot);

}  // namespace balance::foreign
