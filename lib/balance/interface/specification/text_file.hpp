#pragma once
/// The text of a document that a person wrote.

#include <string>

namespace balance {

/// What messages call the document that standard input gives.
inline constexpr const char* standard_input = "<stdin>";

/// @param path "-" or standard_input: what standard input gives
/// @param what it should be, for messages: "spec", "suite"
/// @return at most one byte more than a document may have
/// @throws SystemError if the file cannot be read
std::string read_text_file(const std::string& path, const std::string& what);

/// What a path leads to that is no file to be read: "a folder", "a pipe or a device"; empty if it is a file or nothing.
std::string describe_non_file(const std::string& path);

/// What messages call a document: its path, or standard_input.
inline std::string display_name(const std::string& path) { return path == "-" ? standard_input : path; }

}  // namespace balance
