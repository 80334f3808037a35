#pragma once
/// Readers of foreign robot files, and the files that such a file references.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/xml_document.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

/// Files that a foreign file references (includes, meshes, textures), and those that its includes reference, in every
/// folder where they may be looked for: not all of these paths exist. Empty if the text cannot be parsed.
/// @param file path of the foreign file; its folder is the first to look in
std::vector<std::string> list_referenced_robot_files(const std::string& text, const std::string& file);

// Models of Project Chrono in YAML.

/// Fixed bodies are welded to bodies[0], the ground. The file gives positions and axes of joints in the world frame at
/// its own pose, at which all coordinates are zero; motors become actuated joints.
ForeignModel read_chrono(const specification::SpecCursor& root, const std::string& file);

// Planar mechanisms in natural coordinates, as MBSE (multibody state estimation) writes them in YAML.

/// bodies[0] is the ground. A body's frame has its origin at its first point and x towards its second one;
/// bodies that share a point are connected by a revolute joint, `p3_body0_body2`. Coordinates are zero at the
/// positions of the file's points.
ForeignModel read_mbse(const specification::SpecCursor& root, const std::string& file);

// MJCF, MuJoCo's language.

/// The world is bodies[0]. Coordinates are those of the file minus its `ref`. Bodies with several joints become chains.
/// @throws SpecError listing everything that is wrong with the file or with one that it includes
ForeignModel read_mjcf(const XmlDocument& document);

// One foreign file of any format.

/// Limit for bodies and for joints; larger models make no readable spec.
inline constexpr std::size_t max_model_elements = 2000;

/// @param file name for messages; included files are looked for in its folder
/// @throws SpecError listing everything that is wrong, or if the format is unknown
ForeignModel read_foreign_model(const std::string& text, const std::string& file);

// URDF: links and joints of a tree, or of a graph if links have several parents.

/// Whether the base is fixed.
enum class Base { unknown, fixed };

/// The root link is bodies[0]. Loop closures in the file (`<loop>`, `<constraint>`, `<joint>` inside
/// `<gazebo>`) are joints too.
/// @throws SpecError listing everything that is wrong with the file
ForeignModel read_urdf(const XmlDocument& document);

}  // namespace balance::foreign
