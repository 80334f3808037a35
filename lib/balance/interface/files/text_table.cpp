#include "balance/interface/files/text_table.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string_view>

namespace balance {
namespace {

std::string to_single_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return escape_for_terminal(text);
}

bool is_alphanumeric(const std::string& text, std::size_t at) {
  return at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) || (text[at] & 0x80) != 0);
}

/// Underscores within a word, and brackets without a link target, are not markup: names stay as they are written.
bool is_markup(const std::string& text, std::size_t at) {
  switch (text[at]) {
    case '_': return at == 0 || !is_alphanumeric(text, at - 1) || !is_alphanumeric(text, at + 1);
    case ']': return at + 1 < text.size() && std::string_view("([:").find(text[at + 1]) != std::string_view::npos;
    case '\\': return at + 1 == text.size() || std::ispunct(static_cast<unsigned char>(text[at + 1])) != 0;
    default: return std::string_view("`*~$|").find(text[at]) != std::string_view::npos;
  }
}

/// A fence longer than any run of backticks in the text encloses them; a bar ends a table cell even there.
std::string format_code_span(const std::string& text) {
  std::size_t longest = 0, run = 0;
  std::string inside;
  for (const char c : to_single_line(text)) {
    run = c == '`' ? run + 1 : 0;
    longest = std::max(longest, run);
    inside += c == '|' ? "\\|" : std::string(1, c);
  }
  const std::string fence(longest + 1, '`'), blank = longest > 0 ? " " : "";
  return fence + blank + inside + blank + fence;
}

std::string format_markdown_row(const std::vector<std::string>& cells) {
  std::string text = "|";
  for (const std::string& cell : cells) text += " " + cell + " |";
  return text + "\n";
}

}  // namespace

std::string escape_markdown(const std::string& raw_text) {
  const std::string text = to_single_line(raw_text);
  std::string escaped;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool entity = text[i] == '&' && (is_alphanumeric(text, i + 1) || text.compare(i + 1, 1, "#") == 0);
    if (text[i] == '<')
      escaped += "&lt;";
    else if (entity)
      escaped += "&amp;";
    else if (is_markup(text, i))
      escaped += std::string("\\") + text[i];
    else
      escaped += text[i];
  }
  return escaped;
}

std::string format_markdown_table(const TextTable& table, const std::vector<std::size_t>& code_columns) {
  std::vector<std::string> heading, rule;
  for (const std::string& cell : table.heading) heading.push_back(escape_markdown(cell));
  for (const Align align : table.align) rule.emplace_back(align == Align::left ? "---" : "---:");
  std::string text = format_markdown_row(heading) + format_markdown_row(rule);
  for (const auto& cells : table.rows) {
    std::vector<std::string> escaped;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool is_code = std::find(code_columns.begin(), code_columns.end(), i) != code_columns.end();
      escaped.push_back(is_code ? format_code_span(cells[i]) : escape_markdown(cells[i]));
    }
    text += format_markdown_row(escaped);
  }
  return text;
}

namespace {

/// Spreadsheets take these for the start of a formula, even in quotes.
bool begins_formula(const std::string& text) {
  return !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
}

}  // namespace

std::string escape_csv_field(const std::string& text) {
  const std::string escaped = escape_lines_for_terminal(text);
  const std::string guarded = begins_formula(text) ? "'" + escaped : escaped;
  if (guarded.find_first_of(",\"\n") == std::string::npos) return guarded;
  std::string quoted = "\"";
  for (const char c : guarded) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

namespace {

/// Number of characters, not bytes: UTF-8 continuation bytes have no width.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string format_row(const std::vector<std::string>& cells, const TextTable& table,
                       const std::vector<std::size_t>& widths) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string space(widths[i] - width_of(cells[i]), ' ');
    if (i > 0) line += "  ";
    line += table.align[i] == Align::left ? cells[i] + space : space + cells[i];
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string format_table(const TextTable& raw_table) {
  TextTable table = raw_table;
  for (std::string& cell : table.heading) cell = escape_for_terminal(cell);
  for (auto& row : table.rows)
    for (std::string& cell : row) cell = escape_for_terminal(cell);
  std::vector<std::size_t> widths(table.heading.size(), 0);
  const auto widen = [&](const std::vector<std::string>& cells) {
    if (cells.size() != widths.size()) throw std::invalid_argument("a row of the table has a wrong number of cells");
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], width_of(cells[i]));
  };
  widen(table.heading);
  for (const auto& row : table.rows) widen(row);
  std::string text = format_row(table.heading, table, widths);
  for (const auto& row : table.rows) text += format_row(row, table, widths);
  return text;
}

std::string format_number(double value) { return fmt::format("{:#.6g}", value); }

}  // namespace balance
