#pragma once
/// Which build of the program this is.

#include <string>

namespace balance {

/// SHA-256 of the file that holds this code, the program or a library that it loaded. Another compiler, another option or one
/// changed line make another; the same build gives the same everywhere.
/// @throws SystemError if the file cannot be read
std::string hash_build();

}  // namespace balance
