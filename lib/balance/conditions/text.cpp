#include "balance/conditions/text.hpp"

#include "balance/base/extrema.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance {

std::string linear_combination_text(const std::vector<Parameter>& parameters, const VectorX& coefficients) {
  const double largest = max_abs(coefficients);
  std::string text;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const double c = coefficients[static_cast<Eigen::Index>(p)], size = std::abs(c);
    if (size <= 1e-12 * largest) continue;
    text += text.empty() ? (c < 0 ? "-" : "") : (c < 0 ? " - " : " + ");
    const std::string number = fmt::format("{:.6g}", size);
    if (number != "1") text += number + " ";
    text += parameters[p].name;
  }
  return text.empty() ? "0" : text;
}

}  // namespace balance
