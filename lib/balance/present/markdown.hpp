#pragma once
/// Text from outside (names, titles, messages) as Markdown holds it: nothing in it is markup, HTML or mathematics.

#include "balance/write/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance {

/// On one line, visible as in base/plain_text.hpp; line feeds become blanks.
std::string escape_markdown(const std::string& text);

/// A GitHub table. Cells are texts; those of a code column stand in backticks.
std::string format_markdown_table(const TextTable& table, const std::vector<std::size_t>& code_columns = {});

}  // namespace balance
