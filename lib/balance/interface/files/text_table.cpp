#include "balance/interface/files/text_table.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace balance::files {
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

/// Bytes of the longest beginning that is at most `width` columns wide.
std::size_t fitting_bytes(const std::string& text, std::size_t width) {
  std::size_t bytes = 0, columns = 0;
  for (; bytes < text.size(); ++bytes) {
    const bool is_character_start = (static_cast<unsigned char>(text[bytes]) & 0xC0) != 0x80;
    if (is_character_start && columns++ == width) break;
  }
  return bytes;
}

constexpr std::string_view clause_ends = ",;:";
constexpr std::string_view name_joints = "./_-[(,:=";

/// Where to break a line of which `fitting` bytes fit: at the last blank, or at an earlier one after punctuation that
/// leaves two thirds of the line full; npos: there is no blank.
std::size_t find_blank(const std::string& text, std::size_t begin, std::size_t fitting) {
  const std::size_t last = text.rfind(' ', fitting);
  if (last == std::string::npos || last <= begin) return std::string::npos;
  for (std::size_t at = last; at > begin + 2 * (fitting - begin) / 3; --at)
    if (text[at] == ' ' && clause_ends.find(text[at - 1]) != std::string_view::npos) return at;
  return last;
}

using Widths = std::vector<std::size_t>;

/// The last blank in the bytes that fit, outside of a unit in brackets; npos: there is none.
std::size_t find_cell_blank(const std::string& text, std::size_t fitting) {
  std::size_t last = std::string::npos;
  int depth = 0;
  for (std::size_t at = 0; at <= fitting && at < text.size(); ++at) {
    depth += text[at] == '[' ? 1 : text[at] == ']' ? -1 : 0;
    if (text[at] == ' ' && depth == 0 && at > 0) last = at;
  }
  return last;
}

/// Width of the longest part that wrap_cell keeps whole as long as there is space for it.
std::size_t max_word_width(const std::string& text) {
  std::size_t max_width = 0, begin = 0;
  int depth = 0;
  for (std::size_t at = 0; at <= text.size(); ++at) {
    if (at < text.size()) depth += text[at] == '[' ? 1 : text[at] == ']' ? -1 : 0;
    if (at < text.size() && (text[at] != ' ' || depth != 0)) continue;
    max_width = std::max(max_width, width_of(text.substr(begin, at - begin)));
    begin = at + 1;
  }
  return max_width;
}

/// Rows of a table whose cells may have several lines. A name too long for the first column has a line of its own.
std::string format_row(std::vector<std::string> cells, const TextTable& table, const std::vector<std::size_t>& columns,
                       const Widths& widths, std::size_t width) {
  std::string text;
  if (table.align[0] == Align::left && max_word_width(cells[0]) > widths[0]) {
    for (const std::string& line : wrap_cell(cells[0], width)) text += line + "\n";
    cells[0].clear();
    if (std::all_of(columns.begin(), columns.end(), [&](std::size_t i) { return cells[i].empty(); })) return text;
  }
  std::vector<std::vector<std::string>> lines;
  std::size_t height = 1;
  for (const std::size_t i : columns) {
    lines.push_back(width_of(cells[i]) <= widths[i] ? std::vector<std::string>{cells[i]}
                                                    : wrap_cell(cells[i], widths[i]));
    height = std::max(height, lines.back().size());
  }
  for (std::size_t k = 0; k < height; ++k) {
    std::string line;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::string cell = k < lines[c].size() ? lines[c][k] : "";
      const std::size_t column_width = widths[columns[c]];
      const std::string space(column_width - std::min(column_width, width_of(cell)), ' ');
      if (c > 0) line += "  ";
      line += table.align[columns[c]] == Align::left ? cell + space : space + cell;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::size_t sum_widths(const std::vector<std::size_t>& columns, const Widths& widths) {
  std::size_t sum = columns.empty() ? 0 : 2 * (columns.size() - 1);
  for (const std::size_t i : columns) sum += widths[i];
  return sum;
}

constexpr std::size_t min_text_columns = 20;  ///< to which a column of texts shrinks

/// What a table gives up to become narrower, one after the other.
enum class Shrinking {
  blanks,   ///< long texts and headings are broken at blanks
  remarks,  ///< and short texts
  names,    ///< and names too long for the first column have lines of their own
  words,    ///< and words of texts are broken
};

struct TableWidths {
  Widths natural, minimum;
};

TableWidths measure(const TextTable& table, Shrinking shrinking) {
  TableWidths widths{Widths(table.heading.size(), 0), Widths(table.heading.size(), 0)};
  Widths word(table.heading.size(), 0);
  for (const auto& row : table.rows) {
    if (row.size() != table.heading.size())
      throw std::invalid_argument("a row of the table has a wrong number of cells");
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths.natural[i] = std::max(widths.natural[i], width_of(row[i]));
      word[i] = std::max(word[i], max_word_width(row[i]));
    }
  }
  for (std::size_t i = 0; i < table.heading.size(); ++i) {
    const bool is_broken =
        table.align[i] == Align::left && (shrinking == Shrinking::words || (shrinking == Shrinking::names && i == 0));
    const bool is_remark =
        shrinking != Shrinking::blanks && widths.natural[i] <= min_text_columns && table.heading[i] != "unit";
    const std::size_t cells = table.align[i] == Align::right ? widths.natural[i]
                              : is_broken                    ? std::min(word[i], min_text_columns)
                              : is_remark                    ? word[i]
                                                             : std::max(word[i], min_text_columns);
    widths.minimum[i] = std::max(cells, max_word_width(table.heading[i]));
    widths.natural[i] = std::max(widths.natural[i], width_of(table.heading[i]));
    widths.minimum[i] = std::min(widths.minimum[i], widths.natural[i]);
  }
  return widths;
}

/// Widths of the columns: the widest that may shrink do so until all fit or none can.
Widths shrink_texts(const TableWidths& table, const std::vector<std::size_t>& columns, std::size_t width) {
  Widths widths = table.natural;
  while (sum_widths(columns, widths) > width) {
    std::size_t widest = widths.size();
    for (const std::size_t i : columns)
      if (widths[i] > table.minimum[i] && (widest == widths.size() || widths[i] > widths[widest])) widest = i;
    if (widest == widths.size()) break;
    --widths[widest];
  }
  return widths;
}

/// Groups of columns that stay together: [begin, end) after the key columns.
std::vector<std::pair<std::size_t, std::size_t>> list_column_groups(const TextTable& table) {
  std::vector<std::size_t> begins = table.blocks;
  if (begins.empty())
    for (std::size_t i = table.key_columns; i < table.heading.size(); ++i) begins.push_back(i);
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  for (std::size_t k = 0; k < begins.size(); ++k)
    groups.emplace_back(begins[k], k + 1 < begins.size() ? begins[k + 1] : table.heading.size());
  return groups;
}

/// Columns of every block; one block if they all fit with their texts shrunk.
std::vector<std::vector<std::size_t>> split_columns(const TextTable& table, std::size_t width,
                                                    const TableWidths& widths) {
  std::vector<std::size_t> keys, all;
  for (std::size_t i = 0; i < table.heading.size(); ++i) {
    all.push_back(i);
    if (i < table.key_columns) keys.push_back(i);
  }
  const auto fits = [&](const std::vector<std::size_t>& columns) {
    return sum_widths(columns, shrink_texts(widths, columns, width)) <= width;
  };
  if (fits(all)) return {all};
  std::vector<std::vector<std::size_t>> blocks;
  for (const auto& [begin, end] : list_column_groups(table)) {
    std::vector<std::size_t> wider = blocks.empty() ? keys : blocks.back();
    for (std::size_t i = begin; i < end; ++i) wider.push_back(i);
    if (!blocks.empty() && fits(wider)) {
      blocks.back() = std::move(wider);
      continue;
    }
    blocks.push_back(keys);
    for (std::size_t i = begin; i < end; ++i) blocks.back().push_back(i);
  }
  return blocks.empty() ? std::vector<std::vector<std::size_t>>{all} : blocks;
}

}  // namespace

std::vector<std::string> wrap_cell(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::string rest = text;
  while (width_of(rest) > width) {
    const std::size_t fitting = fitting_bytes(rest, width);
    std::size_t end = find_cell_blank(rest, fitting), next = end + 1;
    if (end == std::string::npos) {
      // not at a bracket that closes, and not so early that the line is nearly empty
      const std::size_t joint = rest.find_last_of(name_joints, fitting - 1);
      end = next = joint != std::string::npos && joint + 1 > fitting / 2 ? joint + 1 : fitting;
    }
    lines.push_back(rest.substr(0, end));
    rest.erase(0, next);
  }
  lines.push_back(rest);
  return lines;
}

std::string wrap_lines(const std::string& text, std::size_t width) {
  std::string wrapped;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at);
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    std::size_t begin = indent;
    while (width_of(line) > width) {
      std::size_t blank = find_blank(line, begin, fitting_bytes(line, width));
      if (blank == std::string::npos) blank = line.find(' ', begin + 1);  // after a word that is too long
      if (blank == std::string::npos) break;
      wrapped += line.substr(0, line.find_last_not_of(' ', blank) + 1) + "\n";
      line = std::string(indent + 2, ' ') + line.substr(std::min(line.find_first_not_of(' ', blank), line.size()));
      begin = indent + 2;
    }
    wrapped += line;
    if (end < text.size()) wrapped += '\n';
    at = end + 1;
  }
  return wrapped;
}

void remove_empty_units(TextTable& table) {
  for (const auto& row : table.rows)
    if (!row[1].empty()) return;
  table.heading.erase(table.heading.begin() + 1);
  table.align.erase(table.align.begin() + 1);
  for (auto& row : table.rows) row.erase(row.begin() + 1);
  table.key_columns = 1;
  for (std::size_t& column : table.blocks) --column;
}

namespace {

struct TableLayout {
  std::vector<std::vector<std::size_t>> blocks;
  TableWidths widths;
};

/// One table is preferred to blocks of columns, as long as no word is broken.
TableLayout lay_out(const TextTable& table, std::size_t width) {
  TableLayout layout;
  const auto try_layout = [&](Shrinking shrinking, bool allows_blocks) {
    layout.widths = measure(table, shrinking);
    layout.blocks = split_columns(table, width, layout.widths);
    return (allows_blocks || layout.blocks.size() == 1) &&
           std::all_of(layout.blocks.begin(), layout.blocks.end(), [&](const std::vector<std::size_t>& columns) {
             return sum_widths(columns, shrink_texts(layout.widths, columns, width)) <= width;
           });
  };
  for (const bool allows_blocks : {false, true})
    for (const Shrinking shrinking : {Shrinking::blanks, Shrinking::remarks, Shrinking::names})
      if (try_layout(shrinking, allows_blocks)) return layout;
  try_layout(Shrinking::words, true);
  return layout;
}

}  // namespace

std::string format_table(const TextTable& raw_table, std::size_t width) {
  TextTable table = raw_table;
  for (std::string& cell : table.heading) cell = escape_for_terminal(cell);
  for (auto& row : table.rows)
    for (std::string& cell : row) cell = escape_for_terminal(cell);
  const auto [blocks, widths] = lay_out(table, width);
  std::string text;
  for (const std::vector<std::size_t>& columns : blocks) {
    const Widths shrunk = shrink_texts(widths, columns, width);
    if (!text.empty()) text += "\n";
    text += format_row(table.heading, table, columns, shrunk, width);
    for (const auto& row : table.rows) text += format_row(row, table, columns, shrunk, width);
  }
  return text;
}

std::string format_number(double value) { return fmt::format("{:#.6g}", value); }

}  // namespace balance::files
