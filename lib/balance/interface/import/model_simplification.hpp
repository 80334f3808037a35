#pragma once
/// Simplifies a file's links and joints to the bodies and joints of a mechanism.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/import.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

// Choice of the joints with motors.

/// Sets `is_actuated` of the named joints; if none is named, of those that the file names; if it names none either and
/// there are no loops, of all movable joints that follow no other. Reports loops without motors. Joints that are
/// coupled to each other have one motor.
/// @param actuated_names names of the file's joints
/// @throws SpecError whose file is `--actuate`
void choose_actuators(ForeignModel& robot, const std::vector<std::string>& actuated_names);

// Plausibility of a file's masses. Nothing is repaired.

/// Adds findings about every body with mass or inertia: inertias that no body can have (by how much, and the nearest
/// possible one), points, placeholders, bodies denser than matter, millimetres taken for metres, inertias about a
/// joint; and about massless bodies that move. Call it before anything is merged.
void lint_masses(ForeignModel& robot);

// From a reader's result to the bodies and joints of a mechanism.

/// Checks masses, chooses motors, merges fixed bodies, replaces massless bodies between joints by joints. Findings
/// are in the order of the file.
/// @throws SpecError if a spec cannot express the model, or if nothing moves
void simplify_model(ForeignModel& robot, const ImportOptions& options);

/// Merges each body with everything fixed to it; frames of merged bodies remain as named points. Bodies fixed to
/// bodies[0] become part of the ground. Reports the merged bodies together.
/// @throws SpecError if fixed joints contradict each other
void merge_fixed_bodies(ForeignModel& robot);

/// Replaces massless bodies between joints by joints: two coaxial revolute joints by one, two whose lines
/// meet at a right angle by a universal joint, three whose lines meet in one point by a spherical joint. A
/// revolute joint whose line passes through an adjacent spherical joint is redundant. Joints that are needed
/// (motors, couplings, friction) stay.
void merge_massless_bodies(ForeignModel& robot);

/// Removes massless bodies at the ends of chains with their joints, unless these have motors. Reports each of them.
void remove_massless_leaves(ForeignModel& robot);

}  // namespace balance::foreign
