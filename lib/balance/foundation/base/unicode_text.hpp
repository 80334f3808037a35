#pragma once
/// Text from outside (names, titles, keys, file names) and what may be done with it. Nothing here depends on the locale.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace balance {

struct Utf8CodePoint {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  ///< 0: not UTF-8 (a surrogate, an overlong form, a stray byte)
};

/// The character at the start of a text that is not empty.
Utf8CodePoint decode_utf8(std::string_view text);

/// Whether every byte belongs to a character of UTF-8.
bool is_utf8(std::string_view text);

/// Whether a character is a control or format character (Unicode's Cc, Cf, Zl, Zp), one that only fills, or none at all.
bool is_invisible(std::uint32_t code);

/// Fit for one line of a terminal, a table or a message: control characters and bytes that are not UTF-8 become `\x1b`, characters
/// that are not seen or turn the direction of writing become `<U+202E>`, line separators too. Everything else stays.
std::string escape_for_terminal(std::string_view text);

/// The same for a text of several lines: line feeds and tabs stay.
std::string escape_lines_for_terminal(std::string_view text);

/// Without blanks, tabs and line ends around it.
std::string_view trim(std::string_view text);

/// Whether a text may be a name in a spec: a letter, then letters, digits, `_` and `-`. A letter is one of ASCII or any character
/// from U+00AA on that is neither white space, punctuation, symbol, control or format character, surrogate, private nor
/// unassigned for good; marks that combine with the letter before them are letters but not the first.
bool is_unicode_identifier(std::string_view text);

}  // namespace balance
