#pragma once
/// The specs in tests/certificate/specs, whole and changed.

#include "balance/motion/study/design_space.hpp"

#include <string>

namespace linkage_specs {

/// @param name of the file, without its ending
std::string read_text(const std::string& name);

/// Replaces a part that must be there.
std::string replace_text(std::string text, const std::string& before, const std::string& after);

/// Whether a design can be assembled and makes the motions that the start values can make.
bool can_move(const balance::DesignSpace& space, const balance::VectorX& x);

}  // namespace linkage_specs
