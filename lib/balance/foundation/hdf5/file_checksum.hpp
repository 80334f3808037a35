#pragma once
/// A checksum at the end of a file, which shows whether the file is still as it was written.

#include <string>

namespace balance::hdf5 {

enum class ChecksumStatus {
  none,      ///< no checksum: a foreign file or a truncated one
  intact,    ///< every byte is as it was written
  mismatch,  ///< some byte has changed
};

/// Appends the checksum of the file's contents: 16 characters, "balance:" and the CRC-32 of everything before in
/// hexadecimal.
/// @param descriptor open for reading and writing
/// @return 0, or the system's error number
int append_checksum(int descriptor);

/// @return ChecksumStatus::none also if the file cannot be read
ChecksumStatus verify_checksum(const std::string& path);

}  // namespace balance::hdf5
