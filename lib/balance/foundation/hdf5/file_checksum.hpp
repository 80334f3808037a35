#pragma once
/// A checksum behind the last byte of a file, which tells whether the file is still as it was written.

#include <string>

namespace balance {

enum class ChecksumStatus {
  none,      ///< there is none: somebody else's file, or one that was cut off
  intact,    ///< every byte is as it was when it was written
  mismatch,  ///< some byte is not
};

/// Appends the checksum of what stands in the file: 16 characters, "balance:" and the CRC-32 of all before in hexadecimal digits.
/// @param descriptor open for reading and writing
/// @return 0, or the number of the system's error
int append_checksum(int descriptor);

/// @return none too if the file cannot be read
ChecksumStatus verify_checksum(const std::string& path);

}  // namespace balance
