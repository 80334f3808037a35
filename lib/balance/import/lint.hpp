#pragma once
/// What is odd about a file's masses. Nothing is repaired.

#include "balance/import/robot.hpp"

namespace balance::foreign {

/// Adds findings about every body with mass or inertia: inertias that no body can have (by how much, and the nearest that one can),
/// points, placeholders, bodies denser than matter, millimetres taken for metres, inertias about a joint; and massless bodies that
/// move. Before anything is merged.
void lint_masses(ForeignModel& robot);

}  // namespace balance::foreign
