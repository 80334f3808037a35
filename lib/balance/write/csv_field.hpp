#pragma once
/// Text in a table of comma-separated values.

#include <string>

namespace balance {

/// A text, not a number, as one field: quoted where a comma or a quote would end it (RFC 4180); behind an apostrophe where a spreadsheet
/// would take it for a formula; visible as in base/plain_text.hpp.
std::string escape_csv_field(const std::string& text);

}  // namespace balance
