#pragma once
/// From a file's links and joints to the bodies and joints of a mechanism.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/import.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

// Which joints have motors.

/// Sets `driven`: of the joints that are named; if none is, of those that the file names; if it names none either and there are no
/// loops, of all that nothing else determines. Loops without motors are told.
/// @param wanted names of the file's joints
/// @throws SpecError whose file is `--actuate`
void choose_actuators(ForeignModel& robot, const std::vector<std::string>& wanted);

// What is odd about a file's masses. Nothing is repaired.

/// Adds findings about every body with mass or inertia: inertias that no body can have (by how much, and the nearest that one can),
/// points, placeholders, bodies denser than matter, millimetres taken for metres, inertias about a joint; and massless bodies that
/// move. Before anything is merged.
void lint_masses(ForeignModel& robot);

// From what a reader found to the bodies and joints of a mechanism.

/// Judges masses, chooses motors, merges what is fixed, turns massless bodies between joints into joints. Findings come in the order
/// of the file.
/// @throws SpecError for what a spec cannot say, or if nothing moves
void simplify_model(ForeignModel& robot, const ImportOptions& options);

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
