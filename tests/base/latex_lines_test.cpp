#include "balance/foundation/base/latex_lines.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using balance::break_latex, balance::latex_width;

namespace {

std::string without_spaces(std::string text) {
  std::erase(text, ' ');
  return text;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

}  // namespace

TEST_CASE("a formula that fits is one line, unchanged") {
  const std::string formula = "\\frac{m_{1} \\left(a + b\\right)}{2} + {\\left(a + b\\right)}^{2}";
  CHECK(break_latex(formula) == std::vector<std::string>{formula});
}

TEST_CASE("a fraction is as wide as its wider part, an index narrower than letters on the line") {
  CHECK(latex_width("\\frac{abcd}{xy}") == doctest::Approx(4));
  CHECK(latex_width("a_{bc}") == doctest::Approx(1 + 2 * 0.7));
  CHECK(latex_width("\\mathrm{mass}") == doctest::Approx(4));
  CHECK(latex_width("\\hat M_{1}") == doctest::Approx(1.7));
}

TEST_CASE("lines are within the limit and say together what the formula says") {
  std::string sum = "J_{1}";
  for (int k = 0; k < 12; ++k)
    sum += " + \\mathrm{mass}_{" + std::to_string(k) + "} \\, \\mathrm{length} \\cos(\\theta_{1})";
  const std::vector<std::string> lines = break_latex(sum, 30);
  CHECK(lines.size() > 5);
  for (const std::string& line : lines) CHECK(latex_width(line) <= 30);
  CHECK(without_spaces(joined(lines)) == without_spaces(sum));
}

TEST_CASE("products without a sign are broken between factors, accents stay with their letter") {
  const std::vector<std::string> lines = break_latex("\\mathrm{abcdefgh} \\, \\mathrm{ijklmnop} \\, \\hat M_{11}", 9);
  REQUIRE(lines.size() == 3);
  CHECK(lines[2].find("\\hat M_{11}") != std::string::npos);
}

TEST_CASE("a fraction wider than a line becomes a quotient whose parts are broken") {
  const std::string wide = "a + b + c + d + e + f + g + h + i + j + k + l + m + n";
  const std::vector<std::string> lines = break_latex("x + \\frac{" + wide + "}{\\Delta} \\cos(A)", 20);
  for (const std::string& line : lines) {
    CHECK(latex_width(line) <= 20);
    CHECK(std::count(line.begin(), line.end(), '{') == std::count(line.begin(), line.end(), '}'));
  }
  CHECK(without_spaces(joined(lines)) ==
        without_spaces("x + \\bigl(\\bigl(" + wide + "\\bigr) / \\Delta\\bigr) \\cos(A)"));
}

TEST_CASE("squares of sums are broken inside") {
  const std::vector<std::string> lines =
      break_latex("m {\\left(\\mathrm{abcdefgh} + \\mathrm{ijklmnop}\\right)}^{2}", 14);
  for (const std::string& line : lines) CHECK(latex_width(line) <= 14);
  CHECK(without_spaces(joined(lines)) == "m\\bigl(\\mathrm{abcdefgh}+\\mathrm{ijklmnop}\\bigr)^{2}");
}
