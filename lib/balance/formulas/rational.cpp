#include "balance/formulas/rational.hpp"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace balance::formulas {

namespace {

__extension__ using Wide = __int128;

Wide common_divisor(Wide a, Wide b) {
  if (a < 0) a = -a;
  while (b != 0) {
    const Wide rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/// The largest whole number is left out, so that every fraction can change its sign.
std::int64_t fitting(Wide number) {
  constexpr Wide most = std::numeric_limits<std::int64_t>::max();
  if (number > most || number < -most) throw FormulaError("a coefficient is too long to be exact");
  return static_cast<std::int64_t>(number);
}

Rational lowest(Wide numerator, Wide denominator) {
  if (denominator == 0) throw FormulaError("a division by zero");
  if (denominator < 0) numerator = -numerator, denominator = -denominator;
  const Wide divisor = common_divisor(denominator, numerator < 0 ? -numerator : numerator);
  if (divisor == 1 && denominator == 1) return {fitting(numerator), 1};
  return {fitting(numerator / divisor), fitting(denominator / divisor)};
}

std::int64_t whole_root(std::int64_t square) {
  const auto near = static_cast<std::int64_t>(std::llround(std::sqrt(static_cast<double>(square))));
  for (const std::int64_t root : {near - 1, near, near + 1})
    if (static_cast<Wide>(root) * root == square) return root;
  return -1;
}

}  // namespace

Rational::Rational(std::int64_t numerator, std::int64_t denominator) : numerator_(numerator), denominator_(1) {
  if (denominator == 1) return;
  if (denominator == 0) throw FormulaError("a division by zero");
  const auto found = static_cast<std::int64_t>(common_divisor(numerator, denominator));
  const std::int64_t divisor = found < 0 ? -found : found;  // never 0: the denominator is not
  const Wide sign = denominator < 0 ? -1 : 1;
  numerator_ = fitting(sign * (numerator / divisor));
  denominator_ = fitting(sign * (denominator / divisor));
}

Rational operator+(Rational a, Rational b) {
  if (a.denominator_ == b.denominator_) return lowest(Wide{a.numerator_} + b.numerator_, a.denominator_);
  const Wide divisor = common_divisor(a.denominator_, b.denominator_);
  const Wide left = a.denominator_ / divisor, right = b.denominator_ / divisor;
  return lowest(a.numerator_ * right + b.numerator_ * left, a.denominator_ * right);
}

Rational operator*(Rational a, Rational b) {
  return lowest(Wide{a.numerator_} * b.numerator_, Wide{a.denominator_} * b.denominator_);
}

bool operator<(Rational a, Rational b) {
  return Wide{a.numerator()} * b.denominator() < Wide{b.numerator()} * a.denominator();
}

Rational Rational::of_text(const std::string& text) {
  std::size_t at = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (negative || (!text.empty() && text[0] == '+')) ++at;
  Rational value;
  int point = 0;
  bool digits = false, behind = false;
  for (; at < text.size() && (std::isdigit(static_cast<unsigned char>(text[at])) != 0 || (text[at] == '.' && !behind));
       ++at) {
    if (text[at] == '.') {
      behind = true;
      continue;
    }
    digits = true;
    value = value * Rational(10) + Rational(text[at] - '0');
    if (behind) ++point;
  }
  long exponent = 0;
  if (digits && at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    char* end = nullptr;
    exponent = std::strtol(text.c_str() + at + 1, &end, 10);
    at = static_cast<std::size_t>(end - text.c_str());
  }
  if (!digits || at != text.size()) throw FormulaError("'" + text + "' is no number");
  if (std::labs(exponent) > 100) throw FormulaError("a coefficient is too long to be exact");
  for (long k = exponent - point; k > 0; --k) value = value * Rational(10);
  for (long k = exponent - point; k < 0; ++k) value = value / Rational(10);
  return negative ? -value : value;
}

Rational root_of(Rational square) {
  const std::int64_t above = whole_root(square.numerator()), below = whole_root(square.denominator());
  return above < 0 || below < 0 ? Rational() : Rational(above, below);
}

}  // namespace balance::formulas
