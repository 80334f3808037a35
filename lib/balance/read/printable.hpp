#pragma once
/// Texts of strangers.

#include <string>
#include <string_view>

namespace balance::read {

/// Whether the text is UTF-8 without NUL.
bool is_text(std::string_view text);

/// The text as one line that does nothing to a terminal: U+FFFD stands for control characters, for those that separate lines or turn
/// the direction of writing, and for every byte that is not UTF-8.
std::string printable(std::string_view text);

}  // namespace balance::read
