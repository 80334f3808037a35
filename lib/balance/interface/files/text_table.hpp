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

/// @throws std::invalid_argument if a row and the heading differ in their number of cells
std::string format_table(const TextTable& table);

/// Six significant digits, trailing zeros kept.
std::string format_number(double value);

// Text from outside (names, titles, messages) in Markdown, escaped so that none of it acts as markup, HTML or
// mathematics.

/// On one line, with invisible characters escaped as in foundation/base/unicode_text.hpp; line feeds become blanks.
std::string escape_markdown(const std::string& text);

/// A GitHub table. Cells are plain text; those of code columns are in backticks.
std::string format_markdown_table(const TextTable& table, const std::vector<std::size_t>& code_columns = {});

// Text in CSV.

/// A text, not a number, as one field: quoted if it contains a comma, a quote or a line feed (RFC 4180); preceded by an
/// apostrophe if a spreadsheet would take it for a formula; with invisible characters escaped as in
/// foundation/base/unicode_text.hpp.
std::string escape_csv_field(const std::string& text);

}  // namespace balance
