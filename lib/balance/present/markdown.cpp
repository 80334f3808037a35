#include "balance/present/markdown.hpp"

#include "balance/base/plain_text.hpp"

#include <algorithm>
#include <cctype>
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

/// Underscores within a word, and brackets without an address behind them, are no markup: names stay as they are written.
bool is_markup(const std::string& text, std::size_t at) {
  switch (text[at]) {
    case '_': return at == 0 || !is_alphanumeric(text, at - 1) || !is_alphanumeric(text, at + 1);
    case ']': return at + 1 < text.size() && std::string_view("([:").find(text[at + 1]) != std::string_view::npos;
    case '\\': return at + 1 == text.size() || std::ispunct(static_cast<unsigned char>(text[at + 1])) != 0;
    default: return std::string_view("`*~$|").find(text[at]) != std::string_view::npos;
  }
}

/// A fence longer than any within holds every backtick; a bar ends a cell even there.
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

std::string escape_markdown(const std::string& given) {
  const std::string text = to_single_line(given);
  std::string safe;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool entity = text[i] == '&' && (is_alphanumeric(text, i + 1) || text.compare(i + 1, 1, "#") == 0);
    if (text[i] == '<')
      safe += "&lt;";
    else if (entity)
      safe += "&amp;";
    else if (is_markup(text, i))
      safe += std::string("\\") + text[i];
    else
      safe += text[i];
  }
  return safe;
}

std::string format_markdown_table(const TextTable& table, const std::vector<std::size_t>& code_columns) {
  std::vector<std::string> heading, rule;
  for (const std::string& cell : table.heading) heading.push_back(escape_markdown(cell));
  for (const Align align : table.align) rule.emplace_back(align == Align::left ? "---" : "---:");
  std::string text = format_markdown_row(heading) + format_markdown_row(rule);
  for (const auto& cells : table.rows) {
    std::vector<std::string> shown;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool is_code = std::find(code_columns.begin(), code_columns.end(), i) != code_columns.end();
      shown.push_back(is_code ? format_code_span(cells[i]) : escape_markdown(cells[i]));
    }
    text += format_markdown_row(shown);
  }
  return text;
}

}  // namespace balance
