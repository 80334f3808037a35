#include "balance/foundation/base/unicode_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>

namespace balance {
namespace {

struct CodeRange {
  std::uint32_t first, last;
};

template <std::size_t Size>
bool is_in_ranges(const CodeRange (&ranges)[Size], std::uint32_t code) {
  const auto* next_range = std::upper_bound(std::begin(ranges), std::end(ranges), code,
                                            [](std::uint32_t c, const CodeRange& range) { return c < range.first; });
  return next_range != std::begin(ranges) && code <= std::prev(next_range)->last;
}

/// Unicode's categories Cc, Cf, Zl, Zp, and fillers that Unicode classifies as letters.
constexpr CodeRange invisible_ranges[]{
    {0x0000, 0x001F},   {0x007F, 0x009F},   {0x00AD, 0x00AD},   {0x034F, 0x034F},   {0x0600, 0x0605},
    {0x061C, 0x061C},   {0x06DD, 0x06DD},   {0x070F, 0x070F},   {0x0890, 0x0891},   {0x08E2, 0x08E2},
    {0x115F, 0x1160},   {0x17B4, 0x17B5},   {0x180B, 0x180F},   {0x200B, 0x200F},   {0x2028, 0x202E},
    {0x2060, 0x206F},   {0x3164, 0x3164},   {0xFEFF, 0xFEFF},   {0xFFA0, 0xFFA0},   {0xFFF0, 0xFFFB},
    {0x110BD, 0x110BD}, {0x110CD, 0x110CD}, {0x13430, 0x1345F}, {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A},
    {0xE0000, 0xE0FFF},
};

/// Non-letters beyond ASCII other than invisible_ranges: blocks of punctuation, symbols, private use and noncharacters.
constexpr CodeRange non_letter_ranges[]{
    {0x0080, 0x00A9}, {0x00AB, 0x00B4}, {0x00B6, 0x00B9},   {0x00BB, 0x00BF},   {0x00D7, 0x00D7},    {0x00F7, 0x00F7},
    {0x02C2, 0x02C5}, {0x02D2, 0x02DF}, {0x02E5, 0x02EB},   {0x02ED, 0x02ED},   {0x02EF, 0x02FF},    {0x0375, 0x0375},
    {0x037E, 0x037E}, {0x0384, 0x0385}, {0x0387, 0x0387},   {0x03F6, 0x03F6},   {0x0482, 0x0482},    {0x055A, 0x055F},
    {0x0589, 0x058F}, {0x05BE, 0x05BE}, {0x05C0, 0x05C0},   {0x05C3, 0x05C3},   {0x05F3, 0x05F4},    {0x0606, 0x060F},
    {0x061B, 0x061F}, {0x066A, 0x066D}, {0x06D4, 0x06D4},   {0x0964, 0x0965},   {0x0E3F, 0x0E3F},    {0x1680, 0x1680},
    {0x1FBD, 0x1FBD}, {0x1FBF, 0x1FC1}, {0x1FCD, 0x1FCF},   {0x1FDD, 0x1FDF},   {0x1FED, 0x1FEF},    {0x1FFD, 0x1FFE},
    {0x2000, 0x2BFF}, {0x2CE5, 0x2CEA}, {0x2CF9, 0x2CFF},   {0x2E00, 0x3004},   {0x3008, 0x3020},    {0x3030, 0x3030},
    {0x303D, 0x303F}, {0x309B, 0x309C}, {0x30A0, 0x30A0},   {0x30FB, 0x30FB},   {0xD800, 0xF8FF},    {0xFD3E, 0xFD3F},
    {0xFDD0, 0xFDEF}, {0xFE00, 0xFE1F}, {0xFE30, 0xFE6F},   {0xFF00, 0xFF0F},   {0xFF1A, 0xFF20},    {0xFF3B, 0xFF40},
    {0xFF5B, 0xFF65}, {0xFFE0, 0xFFFF}, {0x1D000, 0x1D3FF}, {0x1F000, 0x1FFFF}, {0xE0000, 0x10FFFF},
};

/// Combining marks of the scripts that names are likely to use.
constexpr CodeRange combining_mark_ranges[]{
    {0x0300, 0x036F}, {0x0483, 0x0489}, {0x0591, 0x05C7}, {0x0610, 0x061A}, {0x064B, 0x065F}, {0x0670, 0x0670},
    {0x06D6, 0x06ED}, {0x0900, 0x0903}, {0x093A, 0x094F}, {0x0E31, 0x0E3A}, {0x0E47, 0x0E4E}, {0x1AB0, 0x1AFF},
    {0x1DC0, 0x1DFF}, {0x302A, 0x302F}, {0x3099, 0x309A}, {0xFE20, 0xFE2F},
};

bool is_ascii_letter(std::uint32_t code) { return (code >= 'a' && code <= 'z') || (code >= 'A' && code <= 'Z'); }

bool is_letter(std::uint32_t code) {
  if (code < 0x80) return is_ascii_letter(code);
  return !is_invisible(code) && !is_in_ranges(non_letter_ranges, code);
}

/// A code in hexadecimal. @param format printf format for one unsigned int
std::string format_code(const char* format, unsigned code) {
  std::array<char, 16> digits{};
  std::snprintf(digits.data(), digits.size(), format, code);
  return digits.data();
}

std::string escape_text(std::string_view text, bool lines) {
  std::string out;
  while (!text.empty()) {
    const Utf8CodePoint code_point = decode_utf8(text);
    const std::size_t bytes = std::max<std::size_t>(code_point.bytes, 1);
    const bool is_line_character = lines && (code_point.code == '\n' || code_point.code == '\t');
    if (code_point.bytes == 0 || (code_point.code < 0x80 && !is_line_character && is_invisible(code_point.code)))
      out += format_code("\\x%02x", static_cast<unsigned char>(text[0]));
    else if (!is_line_character && is_invisible(code_point.code))
      out += format_code("<U+%04X>", code_point.code);
    else
      out += text.substr(0, bytes);
    text.remove_prefix(bytes);
  }
  return out;
}

}  // namespace

Utf8CodePoint decode_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = first & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3FU);
  }
  constexpr std::uint32_t min_code_by_length[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < min_code_by_length[bytes] || code > 0x10FFFF || surrogate ? Utf8CodePoint{}
                                                                          : Utf8CodePoint{code, bytes};
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = decode_utf8(text).bytes;
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

bool is_invisible(std::uint32_t code) {
  // The last two codes of every plane are noncharacters.
  return is_in_ranges(invisible_ranges, code) || (code & 0xFFFE) == 0xFFFE;
}

std::string escape_for_terminal(std::string_view text) { return escape_text(text, false); }

std::string escape_lines_for_terminal(std::string_view text) { return escape_text(text, true); }

std::string_view trim(std::string_view text) {
  constexpr std::string_view white_space = " \t\r\n";
  const std::size_t first = text.find_first_not_of(white_space);
  return first == std::string_view::npos ? std::string_view{}
                                         : text.substr(first, text.find_last_not_of(white_space) - first + 1);
}

bool is_unicode_identifier(std::string_view text) {
  bool first = true;
  while (!text.empty()) {
    const Utf8CodePoint code_point = decode_utf8(text);
    if (code_point.bytes == 0) return false;
    const bool letter = is_letter(code_point.code) && !(first && is_in_ranges(combining_mark_ranges, code_point.code));
    const bool is_other_character = !first && ((code_point.code >= '0' && code_point.code <= '9') ||
                                               code_point.code == '_' || code_point.code == '-');
    if (!letter && !is_other_character) return false;
    first = false;
    text.remove_prefix(code_point.bytes);
  }
  return !first;
}

}  // namespace balance
