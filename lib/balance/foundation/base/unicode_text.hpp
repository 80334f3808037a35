#pragma once
/// Checks and escapes text from outside (names, titles, keys, file names). Nothing here depends on the locale.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace balance {

struct Utf8CodePoint {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  ///< 0: not UTF-8 (a surrogate, an overlong form, a stray byte)
};

/// Decodes the first character. @pre text is not empty
Utf8CodePoint decode_utf8(std::string_view text);

/// Whether every byte belongs to a UTF-8 character.
bool is_utf8(std::string_view text);

/// Whether a code is a control or format character (Unicode's Cc, Cf, Zl, Zp), an invisible filler or a noncharacter.
bool is_invisible(std::uint32_t code);

/// Makes a text fit for one line of a terminal, a table or a message. ASCII control characters and bytes that are not
/// UTF-8 become `\x1b`; other invisible characters, including line separators and those that change the writing
/// direction, become `<U+202E>`. Everything else stays.
std::string escape_for_terminal(std::string_view text);

/// The same for a text of several lines: line feeds and tabs stay.
std::string escape_lines_for_terminal(std::string_view text);

/// Removes blanks, tabs and line ends at both ends.
std::string_view trim(std::string_view text);

/// Whether a text may be a name in a spec: a letter, then letters, digits, `_` and `-`. Letters are those of ASCII and
/// all characters from U+00AA on except white space, punctuation, symbols, control and format characters, surrogates,
/// private-use characters and noncharacters. Combining marks count as letters, but not in first place.
bool is_unicode_identifier(std::string_view text);

}  // namespace balance
