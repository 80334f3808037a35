#pragma once
/// A file that appears complete or not at all: it grows under a temporary name in the folder of its own name and takes its
/// name when it is safely on disk. Whatever happens before leaves an older file of that name untouched. While it grows it is locked
/// (flock), so that anybody can tell it from what a dead process has left. A symbolic link is never followed.

#include <stdexcept>
#include <string>
#include <string_view>

namespace balance {

/// What to do with an older file of the same name.
enum class OverwritePolicy { forbid, replace };

/// Whether a file is worth waiting for the disk: what can be computed again is not.
enum class Durability { synced, deferred };

/// The user asked to stop; the unfinished file is gone.
class Cancelled : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Fails early what would fail later: call it before a long computation.
/// @throws SystemError if a file of this name exists and must be kept, if the name belongs to something that is no
///         regular file, a symbolic link among them, or if its folder cannot be written or, where there is none, made
void check_writable(const std::string& path, OverwritePolicy existing);

/// The path that means standard output.
inline constexpr const char* standard_output_path = "-";

/// The name that an unfinished file was to get, without its folder; empty if the name is none of an unfinished file with this mark.
std::string parse_temporary_name(const std::string& name, std::string_view mark);

/// Removes an unfinished file whose writer is dead; keeps one that is still being written.
void remove_stale_temporary(const std::string& temporary);

class AtomicFile {
 public:
  /// @param path the name that the file gets in the end. Of standard_output_path, where the complete file is sent to in the end, the
  ///        temporary file has no name
  /// @param mark stands in the temporary name, for whoever looks for files of his own that were left over
  /// Makes the folders where there are none. A file that is replaced leaves its permissions to the new one.
  /// @throws SystemError as check_writable, or if the temporary file cannot be made
  AtomicFile(const std::string& path, OverwritePolicy existing, std::string_view mark = {});

  /// Removes the temporary file unless it was committed.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::string& temporary() const { return temporary_; }

  /// Open for reading and writing; for libraries that write by themselves. Stays open until the end.
  int descriptor() const { return descriptor_; }

  /// Appends bytes. @throws SystemError with the system's reason
  void write(std::string_view bytes);

  /// Waits until the bytes are on disk, unless told otherwise, and gives the file its name.
  /// @throws SystemError; then nothing has changed
  void commit(Durability durability = Durability::synced);

 private:
  void copy_to_standard_output();

  std::string path_, target_, temporary_;  ///< as the user named it; the same resolved; where the bytes grow
  OverwritePolicy existing_;
  int descriptor_ = -1;
};

}  // namespace balance
