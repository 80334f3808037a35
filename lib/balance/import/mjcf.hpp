#pragma once
/// MJCF, MuJoCo's language.

#include "balance/import/robot.hpp"
#include "balance/import/xml_document.hpp"

namespace balance::foreign {

/// The world is bodies[0]. Coordinates are those of the file less its `ref`. Bodies with several joints become chains.
/// @throws SpecError with everything that is wrong with the file or with one that it includes
ForeignModel read_mjcf(const XmlDocument& document);

}  // namespace balance::foreign
