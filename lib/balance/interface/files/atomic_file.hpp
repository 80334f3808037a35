#pragma once
/// A file that appears complete or not at all. It is written under a temporary name in the folder of its final name,
/// and renamed when it is safely on disk. Until then, an older file of that name stays untouched. While it is written
/// it is locked (flock), which distinguishes it from what a dead process has left. Symbolic links are never followed.

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::files {

// Identity of the file that a path refers to.

/// The same for all names of a file: symbolic links, hard links, other paths.
using FileIdentity = std::pair<std::uintmax_t, std::uintmax_t>;

/// The absolute path, with the links and `..` of its folders resolved, including folders that do not exist yet. A link
/// in the last component is not resolved.
std::string resolve_path(const std::string& path);

/// std::nullopt if there is no such file. A missing folder on the way counts as existing: `missing/../file` is `file`.
std::optional<FileIdentity> find_file_identity(const std::string& path);

/// Like find_file_identity for a path that is read: `-` and `<stdin>` mean the file that standard input is, if it is
/// one.
std::optional<FileIdentity> identity_of_input(const std::string& path);

/// Whether two paths refer to the same file, which need not exist yet. Standard input and output are not files.
bool is_same_file(const std::string& a, const std::string& b);

/// A file from which a result is made.
struct InputFile {
  std::string path;
  std::string description;  ///< as in a sentence: "the spec"
};

/// The first input that writing to `output` would replace, whatever the paths and also if read as standard input;
/// nullptr if there is none.
const InputFile* find_replaced_input(const std::string& output, const std::vector<InputFile>& inputs);

/// What to do with an older file of the same name.
enum class OverwritePolicy { forbid, replace };

/// Whether to wait until a file is on disk: unnecessary for what can be computed again.
enum class Durability { synced, deferred };

/// The user cancelled; the unfinished file has been removed.
class Cancelled : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reports early what would fail later: call it before a long computation.
/// @throws SystemError if a file of this name exists and must be kept, if the name belongs to something other than a
/// regular file, such as a symbolic link, or if its folder is not writable or, if missing, cannot be created
void check_writable(const std::string& path, OverwritePolicy existing);

/// The path that stands for standard output.
inline constexpr const char* standard_output_path = "-";

/// The final name, without its folder, of an unfinished file; empty if `name` is not that of an unfinished file with
/// this mark.
std::string parse_temporary_name(const std::string& name, std::string_view mark);

/// Removes an unfinished file whose writer has ended; keeps one that is still being written.
void remove_stale_temporary(const std::string& temporary);

class AtomicFile {
 public:
  /// Creates missing folders. A replaced file passes its permissions on to the new one.
  /// @param path final name of the file. For standard_output_path, the temporary file has no name and is copied to
  /// standard output when complete
  /// @param mark part of the temporary name, by which leftover files can be found
  /// @throws SystemError as check_writable, or if the temporary file cannot be created
  AtomicFile(const std::string& path, OverwritePolicy existing, std::string_view mark = {});

  /// Removes the temporary file unless it was committed.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::string& temporary() const { return temporary_; }

  /// Open for reading and writing, for libraries that write by themselves. Stays open until commit().
  int descriptor() const { return descriptor_; }

  /// Appends bytes. @throws SystemError with the system's reason
  void write(std::string_view bytes);

  /// Waits until the bytes are on disk, unless deferred, and gives the file its final name.
  /// @throws SystemError; then nothing has changed
  void commit(Durability durability = Durability::synced);

 private:
  void copy_to_standard_output();

  std::string path_, target_, temporary_;  ///< path as given by the user, the same resolved, path of the temporary file
  OverwritePolicy existing_;
  int descriptor_ = -1;
};

}  // namespace balance::files
