#pragma once
/// The files that a robot file is made of, besides itself.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/xml_document.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <string>
#include <vector>

namespace balance {

/// What a foreign file includes or names (parts, meshes, textures) and what those that are included name, wherever it may be looked for:
/// not all of these paths exist. Nothing for a text that cannot be read.
/// @param file what messages call it: other files are looked for from its folder
std::vector<std::string> list_referenced_robot_files(const std::string& text, const std::string& file);

}  // namespace balance

namespace balance::foreign {

// Models of Project Chrono in YAML.

/// Fixed bodies are part of bodies[0]. Joints are said by their place and axis in the world of the file's pose, where all
/// coordinates are zero; motors are joints that are driven.
ForeignModel read_chrono(const specification::SpecCursor& root, const std::string& file);

// Planar mechanisms in natural coordinates, as MBSE (multibody state estimation) writes them in YAML.

/// What is fixed is bodies[0]. A body's frame has its origin at its first point and x towards its second one; where bodies share a
/// point there is a revolute joint, `p3_body0_body2`. Coordinates are zero where the file's points are.
ForeignModel read_mbse(const specification::SpecCursor& root, const std::string& file);

// MJCF, MuJoCo's language.

/// The world is bodies[0]. Coordinates are those of the file less its `ref`. Bodies with several joints become chains.
/// @throws SpecError with everything that is wrong with the file or with one that it includes
ForeignModel read_mjcf(const XmlDocument& document);

// One foreign file, whatever its format.

/// Larger ones make no readable spec.
inline constexpr std::size_t max_model_elements = 2000;

/// @param file what messages call it; files that it includes are looked for in its folder
/// @throws SpecError with everything that is wrong, or if it is of no format that is known
ForeignModel read_foreign_model(const std::string& text, const std::string& file);

// URDF: links and joints of a tree, or of a graph where links have several parents.

/// What is held still.
enum class Base { unknown, fixed };

/// The root link is bodies[0]. Closures said in the file (`<loop>`, `<constraint>`, `<joint>` inside `<gazebo>`) are joints too.
/// @throws SpecError with everything that is wrong with the file
ForeignModel read_urdf(const XmlDocument& document);

}  // namespace balance::foreign
