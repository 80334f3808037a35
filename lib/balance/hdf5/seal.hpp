#pragma once
/// A checksum behind the last byte of a file, which tells whether the file is still as it was written.

#include <string>

namespace balance {

enum class Seal {
  none,    ///< there is none: somebody else's file, or one that was cut off
  intact,  ///< every byte is as it was when the file was sealed
  broken,  ///< some byte is not
};

/// Appends the seal to what stands in the file: 16 characters, "balance:" and the CRC-32 of all before in hexadecimal digits.
/// @param descriptor open for reading and writing
/// @return 0, or the number of the system's error
int seal_file(int descriptor);

/// @return none too if the file cannot be read
Seal seal_of(const std::string& path);

}  // namespace balance
