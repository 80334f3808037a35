#pragma once
/// The only place that knows OpenSSL.

#include <string>
#include <string_view>

namespace balance {

/// SHA-256 as 64 lower-case hexadecimal digits. @throws SystemError if the library refuses
std::string sha256(std::string_view bytes);

/// The same of a file's bytes; empty if it cannot be read. @throws SystemError if the library refuses
std::string sha256_of_file(const std::string& path);

}  // namespace balance
