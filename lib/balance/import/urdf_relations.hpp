#pragma once
/// What a URDF says of joints besides where they are. Private to the reader of URDF.

#include "balance/import/element_reader.hpp"
#include "balance/import/robot.hpp"

namespace balance::foreign {

/// `<mimic>` becomes a coupling. All joints are in the robot.
void read_urdf_mimics(const XmlElement& root, ForeignDiagnostics& faults, ForeignModel& robot);

/// `<transmission>` names joints that have motors.
void read_urdf_transmissions(const XmlElement& root, ForeignModel& robot);

}  // namespace balance::foreign
