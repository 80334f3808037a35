#pragma once
/// A file that appears complete or not at all: it grows under a temporary name in the folder of its own name and takes its
/// name when it is safely on disk. Whatever happens before leaves an older file of that name untouched. While it grows it is locked
/// (flock), so that anybody can tell it from what a dead process has left. A symbolic link is never followed.

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance {

// Which file a name means, whatever it is called.

/// The same for all names of a file: by symbolic links, hard links, other paths.
using FileIdentity = std::pair<std::uintmax_t, std::uintmax_t>;

/// The same path, from the root, with the links and `..` of its folders worked out, those of folders that are still to be made too. What
/// the last name itself links to is left alone.
std::string resolve_path(const std::string& path);

/// Nothing if there is no such file. A folder on the way that is missing counts as made: `missing/../file` is `file`.
std::optional<FileIdentity> find_file_identity(const std::string& path);

/// As find_file_identity, of a name that is read: of `-` and `<stdin>` the file that standard input is, if it is one.
std::optional<FileIdentity> identity_of_input(const std::string& path);

/// Whether two names are one file, which need not exist yet. Standard input and output are no files.
bool is_same_file(const std::string& a, const std::string& b);

/// A file that something is made from.
struct InputFile {
  std::string path;
  std::string description;  ///< in a sentence: "the spec"
};

/// The first of the inputs that a file written to `output` would replace, by whatever path, by way of standard input too; null if there
/// is none.
const InputFile* find_replaced_input(const std::string& output, const std::vector<InputFile>& inputs);

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
  /// @param mark stands in the temporary name, to find files that were left over
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
