#pragma once
/// Which file a name means, whatever it is called.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace balance {

/// The same for all names of a file: by symbolic links, hard links, other paths.
using FileIdentity = std::pair<std::uintmax_t, std::uintmax_t>;

/// Nothing if there is no such file.
std::optional<FileIdentity> identity_of(const std::string& path);

/// Whether two names are one file, which need not exist yet. Standard input and output are no files.
bool same_file(const std::string& a, const std::string& b);

}  // namespace balance
