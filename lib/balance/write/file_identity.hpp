#pragma once
/// Which file a name means, whatever it is called.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

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

}  // namespace balance
