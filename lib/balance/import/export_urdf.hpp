#pragma once
/// A balanced spec's masses go back into the URDF that the spec was imported from.

#include "balance/import/import.hpp"
#include "balance/study/study.hpp"

#include <string>
#include <vector>

namespace balance {

struct ExportedUrdf {
  std::string text;                  ///< the file with other numbers
  std::vector<std::string> changed;  ///< links
  std::vector<std::string> notes;    ///< what the file cannot say
};

/// Masses, centres of mass and inertias of the spec's bodies, with their counterweights, written into the links that they are from.
/// Of links that became one body the first with an `<inertial>` takes what changed. Nothing else of the text changes.
/// @param options as the file was imported
/// @throws SpecError if the file is wrong, or if a body has other links in it, or none that could take its mass
ExportedUrdf export_urdf(const Study& study, const std::string& text, const std::string& file,
                         const ImportOptions& options);

/// Counterweights and discs, one a line: name, kind, body, place in the body [m], mass [kg], inertia [kg m²].
std::string parts_csv(const Mechanism& mechanism);

}  // namespace balance
