#pragma once
/// Changes values in the text of a spec; everything else, comments and layout included, stays as it is.

#include <stdexcept>
#include <string>
#include <vector>

namespace balance::specification {

/// A value for a key: {"bodies", "link1", "mass"} and "1.25". Keys that are missing are added.
struct SpecEdit {
  std::vector<std::string> path;
  std::string value;  ///< YAML on one line
};

/// Where a text cannot be changed: what is changed is an alias or comes from another file.
struct SpecEditError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// @param text a valid spec
/// @param edits of different keys; of a mapping either itself or keys in it
/// @throws SpecEditError
std::string edit_spec(const std::string& text, const std::vector<SpecEdit>& edits);

/// A number as a YAML scalar with this many significant digits.
std::string format_yaml_number(double value, int digits = 12);

/// SI value of the number one, where a spec expects a force. @param text a valid spec
double read_force_unit(const std::string& text);

}  // namespace balance::specification
