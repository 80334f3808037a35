#include "balance/write/sha256.hpp"

#include "balance/base/error.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>

namespace balance {

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw SystemError("the cryptographic library cannot compute SHA-256");
  }
  std::string digits;
  for (unsigned int i = 0; i < size; ++i) digits += fmt::format("{:02x}", digest[i]);
  return digits;
}

}  // namespace balance
