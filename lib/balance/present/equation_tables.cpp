#include "balance/present/equation_tables.hpp"

#include "balance/base/extrema.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double zero_entry_tolerance = 1e-13;  ///< of the largest entry of its kind: shown as 0

}  // namespace

std::string format_entry(double value, double size) {
  return std::abs(value) <= zero_entry_tolerance * size ? "0" : fmt::format("{:.6g}", value);
}

std::string matrix_text(const MatrixX& matrix, const std::vector<std::string>& rows,
                        const std::vector<std::string>& columns) {
  TextTable table{{""}, {Align::left}, {}};
  for (const std::string& column : columns) {
    table.heading.push_back(column);
    table.align.push_back(Align::right);
  }
  const double size = max_abs(matrix);
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    std::vector<std::string> cells{"  " + rows[static_cast<std::size_t>(r)]};
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) cells.push_back(format_entry(matrix(r, c), size));
    table.rows.push_back(std::move(cells));
  }
  return format_table(table);
}

std::string velocity_table(const IndependentTerms& terms, const std::vector<std::string>& rows,
                           const std::vector<std::string>& factors) {
  double size = 1e-3 * max_abs(terms.mass);
  for (const MatrixX& form : terms.velocity) size = std::max(size, max_abs(form));
  std::string text;
  for (std::size_t k = 0; k < terms.velocity.size(); ++k) {
    const MatrixX& form = terms.velocity[k];
    std::string sum;
    for (Eigen::Index r = 0; r < form.rows(); ++r)
      for (Eigen::Index s = r; s < form.cols(); ++s) {
        if (std::abs(form(r, s)) <= zero_entry_tolerance * size) continue;
        const auto& first = factors[static_cast<std::size_t>(r)];
        const auto& second = factors[static_cast<std::size_t>(s)];
        sum += sum.empty() ? (form(r, s) < 0 ? "-" : "") : form(r, s) < 0 ? " - " : " + ";
        sum += fmt::format("{}{:.6g} {}", r == s ? "" : "2 ", std::abs(form(r, s)),
                           r == s ? first + "^2" : first + " " + second);
      }
    text += fmt::format("  {}: {}\n", rows[k], sum.empty() ? "0" : sum);
  }
  return text;
}

}  // namespace balance
