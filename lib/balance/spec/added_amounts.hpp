#pragma once
/// What a designer adds to balance a mechanism: masses and moments of inertia of counterweights and discs, stiffnesses of springs.
/// Such numbers start at 0, where nobody says otherwise: what is added is not there to begin with. Private to spec.

#include "balance/spec/node.hpp"

#include <set>
#include <string>

namespace balance::specification {

/// @param path of a number, `counterweights.cw1.mass`
bool is_added_element_path(const std::string& path);

/// The parameters that feed such numbers and nothing else, through other parameters or not, and let them have a value at 0.
/// @param root the document
std::set<std::string> list_added_element_parameters(const YamlNode& root);

}  // namespace balance::specification
