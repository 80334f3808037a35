#pragma once
/// From a file's links and joints to the bodies and joints of a mechanism.

#include "balance/import/robot.hpp"

#include <vector>

namespace balance::foreign {

/// The body and everything fixed to it become one; frames of what was merged stay as named places. What is fixed to bodies[0] stands
/// still with it. Told once, as a count.
/// @throws SpecError if fixed joints contradict each other
void merge_fixed_bodies(ForeignModel& robot);

/// Bodies without mass between joints become joints: two revolute joints about one line are one, about two lines that meet at a
/// right angle a universal joint, three whose lines meet a spherical one; a revolute joint next to a spherical one on its line is
/// idle. Joints that are needed (motors, couplings, friction) stay.
void merge_massless_bodies(ForeignModel& robot);

/// Leaves out massless bodies at the ends of chains, with their joints unless these have motors. Told.
void remove_massless_leaves(ForeignModel& robot);

}  // namespace balance::foreign
