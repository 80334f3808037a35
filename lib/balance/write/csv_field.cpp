#include "balance/write/csv_field.hpp"

#include "balance/base/plain_text.hpp"

#include <string_view>

namespace balance {

namespace {

/// Spreadsheets take these for the beginning of a formula, in quotes too.
bool begins_formula(const std::string& text) {
  return !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
}

}  // namespace

std::string escape_csv_field(const std::string& text) {
  const std::string shown = escape_lines_for_terminal(text);
  const std::string harmless = begins_formula(text) ? "'" + shown : shown;
  if (harmless.find_first_of(",\"\n") == std::string::npos) return harmless;
  std::string quoted = "\"";
  for (const char c : harmless) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace balance
