#pragma once
/// The only place that knows OpenSSL.

#include <string>
#include <string_view>

namespace balance {

/// SHA-256 as 64 lower-case hexadecimal digits. @throws SystemError if the library refuses
std::string sha256(std::string_view bytes);

}  // namespace balance
