#pragma once
/// Writes the masses of a balanced spec back into the URDF or MJCF that the spec was imported from.

#include "balance/interface/import/import.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

struct MassExport {
  std::string text;                  ///< the file with the new numbers
  std::vector<std::string> changed;  ///< names of the links or bodies that changed
  std::vector<std::string> notes;    ///< what the file cannot express
};

/// Writes mass, centre of mass and inertia of the spec's bodies, including their counterweights, into the links or
/// bodies that they come from. If several links were merged into one body, the first suitable one takes the whole
/// change: a link with an `<inertial>`, or any body of an MJCF. The rest of the text does not change.
/// @param options those of the import
/// @throws SpecError if the file is invalid, if it has no link for a body, or if no link of a body can take its mass
MassExport export_masses(const Study& study, const std::string& text, const std::string& file,
                         const ImportOptions& options);

/// Counterweights and discs as CSV, one per line: name, kind, body, position in the body frame [m],
/// mass [kg], inertia [kg m²].
std::string format_balancing_elements_csv(const Mechanism& mechanism);

}  // namespace balance::foreign
