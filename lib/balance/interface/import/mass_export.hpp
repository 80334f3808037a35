#pragma once
/// A balanced spec's masses go back into the URDF or MJCF that the spec was imported from.

#include "balance/interface/import/import.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance {

struct MassExport {
  std::string text;                  ///< the file with other numbers
  std::vector<std::string> changed;  ///< links or bodies
  std::vector<std::string> notes;    ///< what the file cannot say
};

/// Masses, centres of mass and inertias of the spec's bodies, with their counterweights, written into the links or bodies that they
/// are from. Of those that became one body the first that can takes what changed: a link with an `<inertial>`, any body of an MJCF. Nothing
/// else of the text changes.
/// @param options as the file was imported
/// @throws SpecError if the file is wrong, or if a body has other links in it, or none that could take its mass
MassExport export_masses(const Study& study, const std::string& text, const std::string& file,
                         const ImportOptions& options);

/// Counterweights and discs, one a line: name, kind, body, place in the body [m], mass [kg], inertia [kg m²].
std::string format_balancing_elements_csv(const Mechanism& mechanism);

}  // namespace balance
