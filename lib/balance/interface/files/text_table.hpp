#pragma once
/// Aligned columns of text.

#include <cstddef>
#include <string>
#include <vector>

namespace balance {

enum class Align { left, right };

/// Rows of cells under a heading; two spaces between columns, none at the end of a line.
struct TextTable {
  std::vector<std::string> heading;
  std::vector<Align> align;  ///< one per column
  std::vector<std::vector<std::string>> rows;
};

/// @throws std::invalid_argument if a row has not as many cells as the heading
std::string format_table(const TextTable& table);

/// Six significant digits, trailing zeros kept.
std::string format_number(double value);

// Text from outside (names, titles, messages) as Markdown holds it: nothing in it is markup, HTML or mathematics.

/// On one line, visible as in foundation/base/unicode_text.hpp; line feeds become blanks.
std::string escape_markdown(const std::string& text);

/// A GitHub table. Cells are texts; those of a code column stand in backticks.
std::string format_markdown_table(const TextTable& table, const std::vector<std::size_t>& code_columns = {});

// Text in a table of comma-separated values.

/// A text, not a number, as one field: quoted where a comma or a quote would end it (RFC 4180); behind an apostrophe where a spreadsheet
/// would take it for a formula; visible as in foundation/base/unicode_text.hpp.
std::string escape_csv_field(const std::string& text);

}  // namespace balance
