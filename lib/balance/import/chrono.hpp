#pragma once
/// Models of Project Chrono in YAML.

#include "balance/import/robot.hpp"
#include "balance/spec/cursor.hpp"

namespace balance::foreign {

/// Fixed bodies are part of bodies[0]. Joints are said by their place and axis in the world of the file's pose, where all
/// coordinates are zero; motors are joints that are driven.
ForeignModel read_chrono(const specification::SpecCursor& root, const std::string& file);

}  // namespace balance::foreign
