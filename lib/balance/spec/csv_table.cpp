#include "balance/base/nearest.hpp"
#include "balance/spec/table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>

namespace balance::specification {

namespace {

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string_view::npos ? std::string_view{}
                                         : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> parts;
  for (std::size_t start = 0;;) {
    const auto comma = line.find(',', start);
    parts.push_back(trim(line.substr(start, comma - start)));
    if (comma == std::string_view::npos) return parts;
    start = comma + 1;
  }
}

double number(std::string_view text, long line) {
  std::string_view digits = text;
  if (digits.size() > 1 && digits[0] == '+') digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
    throw TableError(fmt::format("line {}: expected a finite number, found {}", line, quote_for_message(text)));
  return value;
}

void read_line(std::string_view line, long number_of_line, RawTable& table) {
  const auto parts = split(line);
  if (table.columns.empty()) {
    table.columns.assign(parts.begin(), parts.end());
    return;
  }
  if (parts.size() != table.columns.size())
    throw TableError(fmt::format("line {}: expected {} numbers as in the line of names, found {}", number_of_line,
                                 table.columns.size(), parts.size()));
  std::vector<double> row;
  row.reserve(parts.size());
  for (const std::string_view part : parts) row.push_back(number(part, number_of_line));
  table.rows.push_back(std::move(row));
}

}  // namespace

RawTable parse_csv(const std::string& text) {
  RawTable table;
  std::string_view rest = text;
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  for (long line = 1; !rest.empty(); ++line) {
    const auto end = rest.find('\n');
    const std::string_view content = trim(rest.substr(0, std::min(end, rest.find('#'))));
    if (!content.empty()) read_line(content, line, table);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  if (table.columns.empty()) throw TableError("expected a line of column names, found an empty file");
  return table;
}

}  // namespace balance::specification
