#pragma once
/// Reads the text of a document.

#include <string>

namespace balance::specification {

/// Name of the standard input in messages.
inline constexpr const char* standard_input = "<stdin>";

/// @param path "-" or standard_input: reads the standard input
/// @param what kind of document, for messages: "spec", "suite"
/// @return the text, at most one byte longer than a document may be
/// @throws SystemError if the file cannot be read
std::string read_text_file(const std::string& path, const std::string& what);

/// What a path leads to if it is not a file: "a folder", "a pipe or a device"; empty if it is a file or does not exist.
std::string describe_non_file(const std::string& path);

/// Name of a document in messages: its path, or standard_input.
inline std::string display_name(const std::string& path) { return path == "-" ? standard_input : path; }

}  // namespace balance::specification
