#pragma once
/// Aligned columns of text.

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

}  // namespace balance
