#pragma once
/// URDF: links and joints of a tree, or of a graph where links have several parents.

#include "balance/import/robot.hpp"
#include "balance/import/xml_document.hpp"

namespace balance::foreign {

/// What is held still.
enum class Base { unknown, fixed };

/// The root link is bodies[0]. Closures said in the file (`<loop>`, `<constraint>`, `<joint>` inside `<gazebo>`) are joints too.
/// @throws SpecError with everything that is wrong with the file
ForeignModel read_urdf(const XmlDocument& document);

}  // namespace balance::foreign
