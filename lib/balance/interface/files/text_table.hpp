#pragma once
/// Aligned columns of text.

#include <cstddef>
#include <string>
#include <vector>

namespace balance::files {

enum class Align { left, right };

/// Columns of a terminal, and of text that goes elsewhere.
inline constexpr std::size_t default_text_width = 80;

/// Rows of cells under a heading; two spaces between columns, none at the end of a line.
struct TextTable {
  std::vector<std::string> heading;
  std::vector<Align> align;  ///< one per column
  std::vector<std::vector<std::string>> rows;
  std::size_t key_columns = 1;           ///< first columns, repeated in every block of a table that is split
  std::vector<std::size_t> blocks = {};  ///< columns at which it may be split; empty: at any
};

/// A table that is too wide has its texts (left-aligned cells) and headings wrapped at blanks. If that is not enough,
/// names too long for the first column have lines of their own above the rest of the row; then the table is split into
/// blocks of columns, one below the other; at last words are broken. Numbers are never cut.
/// @param width columns that no line exceeds, if every number fits beside the key columns
/// @throws std::invalid_argument if a row and the heading differ in their number of cells
std::string format_table(const TextTable& table, std::size_t width = default_text_width);

/// Removes the second of two key columns, that of units, if no row has one.
void remove_empty_units(TextTable& table);

/// Text in lines of at most `width` columns: longer ones are broken at blanks, rather after a comma, semicolon or colon,
/// and continued with two more blanks than they begin with. Words are not broken.
std::string wrap_lines(const std::string& text, std::size_t width = default_text_width);

/// Lines of at most `width` columns of a text without line feeds; longer words are broken, rather after punctuation.
std::vector<std::string> wrap_cell(const std::string& text, std::size_t width);

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

}  // namespace balance::files
