#pragma once
/// A file that appears complete or not at all: it grows under a temporary name in the folder of its own name and takes its
/// name when it is safely on disk. Whatever happens before leaves an older file of that name untouched.

#include <stdexcept>
#include <string>
#include <string_view>

namespace balance {

/// What to do with an older file of the same name.
enum class Existing { keep, replace };

/// Whether a file is worth waiting for the disk: what can be computed again is not.
enum class Durability { wait, later };

/// The user asked to stop; the unfinished file is gone.
class Cancelled : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Fails early what would fail later: call it before a long computation.
/// @throws SystemError if a file of this name exists and must be kept, if the name belongs to something that is no
///         regular file, or if its folder does not exist or cannot be written
void check_writable(const std::string& path, Existing existing);

/// The path that means standard output.
inline constexpr const char* standard_output = "-";

class PendingFile {
 public:
  /// @param path the name that the file gets in the end; a symbolic link is followed. Of standard_output, where the complete
  ///        file is sent to in the end, the temporary file has no name
  /// @throws SystemError as check_writable, or if the temporary file cannot be made
  PendingFile(const std::string& path, Existing existing);

  /// Removes the temporary file unless it was committed.
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::string& temporary() const { return temporary_; }

  /// Open for reading and writing; for libraries that write by themselves. Stays open until the end.
  int descriptor() const { return descriptor_; }

  /// Appends bytes. @throws SystemError with the system's reason
  void write(std::string_view bytes);

  /// Waits until the bytes are on disk, unless told otherwise, and gives the file its name.
  /// @throws SystemError; then nothing has changed
  void commit(Durability durability = Durability::wait);

 private:
  void send();

  std::string path_, target_, temporary_;  ///< as the user named it; links followed; where the bytes grow
  Existing existing_;
  int descriptor_ = -1;
};

}  // namespace balance
