#pragma once
/// SHA-256. The only place that uses OpenSSL.

#include <string>
#include <string_view>

namespace balance::files {

/// SHA-256 as 64 lower-case hexadecimal digits. @throws SystemError if the library fails
std::string sha256(std::string_view bytes);

/// The same for a file's contents; empty if it cannot be read. @throws SystemError if the library fails
std::string sha256_of_file(const std::string& path);

}  // namespace balance::files
