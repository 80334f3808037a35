#pragma once
/// The text of a document that a person wrote.

#include <string>

namespace balance {

/// @param what it should be, for messages: "spec", "suite"
/// @return at most one byte more than a document may have
/// @throws SystemError if the file cannot be read
std::string read_text_file(const std::string& path, const std::string& what);

}  // namespace balance
