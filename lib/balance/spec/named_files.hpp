#pragma once
/// The files that a spec is read with.

#include <string>
#include <vector>

namespace balance {

/// Values of the keys `file` anywhere in a spec: tables that it is read with. Nothing if the text is no YAML.
std::vector<std::string> files_named_in(const std::string& spec_text);

}  // namespace balance
