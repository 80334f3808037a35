#pragma once
/// One foreign file, whatever its format.

#include "balance/import/robot.hpp"

#include <string>

namespace balance::foreign {

/// Larger ones make no readable spec.
inline constexpr std::size_t max_model_elements = 2000;

/// @param file what messages call it; files that it includes are looked for in its folder
/// @throws SpecError with everything that is wrong, or if it is of no format that is known
ForeignModel read_foreign_model(const std::string& text, const std::string& file);

}  // namespace balance::foreign
