#include "balance/write/table.hpp"

#include "balance/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {
namespace {

/// Characters, not bytes: continuation bytes of UTF-8 take no room.
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

std::string format_table(const TextTable& wanted) {
  TextTable table = wanted;
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
