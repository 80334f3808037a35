#pragma once
/// The files that a spec is read with.

#include <string>
#include <vector>

namespace balance {

/// Tables, parts, and the tables and parts of parts, with their folders; each once. What cannot be read names nothing.
/// @param spec_file what messages call the spec: its files are looked for in its folder
std::vector<std::string> list_referenced_files(const std::string& spec_text, const std::string& spec_file);

/// The spec itself, where it is a file, and what list_referenced_files says of it. A text that has its parts in it already does not name them,
/// so the file is looked at again.
std::vector<std::string> list_spec_files(const std::string& spec_text, const std::string& spec_file);

}  // namespace balance
