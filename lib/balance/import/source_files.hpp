#pragma once
/// The files that a robot file is made of, besides itself.

#include <string>
#include <vector>

namespace balance {

/// What a foreign file includes or names (parts, meshes, textures) and what those that are included name, wherever it may be looked for:
/// not all of these paths exist. Nothing for a text that cannot be read.
/// @param file what messages call it: other files are looked for from its folder
std::vector<std::string> list_referenced_robot_files(const std::string& text, const std::string& file);

}  // namespace balance
