#include "balance/read/printable.hpp"

#include <cstddef>
#include <cstdint>

namespace balance::read {

namespace {

struct Letter {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  ///< 0: not UTF-8
};

unsigned byte_at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

/// Neither overlong forms nor halves of pairs (RFC 3629).
Letter first_letter(std::string_view text) {
  const unsigned lead = byte_at(text, 0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte_at(text, i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte_at(text, i) & 0x3F);
  }
  const std::uint32_t least = bytes == 4 ? 0x10000 : bytes == 3 ? 0x800 : 0x80;
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  return code < least || code > 0x10FFFF || surrogate ? Letter{} : Letter{code, bytes};
}

bool is_harmless(std::uint32_t code) {
  const auto in = [code](std::uint32_t first, std::uint32_t last) { return first <= code && code <= last; };
  const bool control = code < 0x20 || in(0x7F, 0x9F) || in(0xFFF9, 0xFFFB);
  const bool turns = code == 0x61C || in(0x200E, 0x200F) || in(0x202A, 0x202E) || in(0x2066, 0x2069);
  return !control && !turns && !in(0x2028, 0x2029) && code != 0xFEFF;
}

}  // namespace

bool is_text(std::string_view text) {
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    if (letter.bytes == 0 || letter.code == 0) return false;
    text.remove_prefix(letter.bytes);
  }
  return true;
}

std::string printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    if (letter.bytes > 0 && is_harmless(letter.code))
      shown += text.substr(0, letter.bytes);
    else
      shown += "\uFFFD";
    text.remove_prefix(letter.bytes > 0 ? letter.bytes : 1);
  }
  return shown;
}

}  // namespace balance::read
