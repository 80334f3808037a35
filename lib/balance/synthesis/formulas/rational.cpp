#include "balance/synthesis/formulas/rational.hpp"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace balance::formulas {

namespace {

__extension__ using Int128 = __int128;

Int128 common_divisor(Int128 a, Int128 b) {
  if (a < 0) a = -a;
  while (b != 0) {
    const Int128 remainder = a % b;
    a = b;
    b = remainder;
  }
  return a;
}

/// The smallest integer is excluded, so that every fraction can change its sign.
std::int64_t narrow_to_int64(Int128 number) {
  constexpr Int128 max_int64 = std::numeric_limits<std::int64_t>::max();
  if (number > max_int64 || number < -max_int64) throw FormulaError("a coefficient is too long to be exact");
  return static_cast<std::int64_t>(number);
}

Rational reduce_fraction(Int128 numerator, Int128 denominator) {
  if (denominator == 0) throw FormulaError("a division by zero");
  if (denominator < 0) numerator = -numerator, denominator = -denominator;
  const Int128 divisor = common_divisor(denominator, numerator < 0 ? -numerator : numerator);
  if (divisor == 1 && denominator == 1) return {narrow_to_int64(numerator), 1};
  return {narrow_to_int64(numerator / divisor), narrow_to_int64(denominator / divisor)};
}

std::int64_t integer_square_root(std::int64_t square) {
  const auto estimate = static_cast<std::int64_t>(std::llround(std::sqrt(static_cast<double>(square))));
  for (const std::int64_t root : {estimate - 1, estimate, estimate + 1})
    if (static_cast<Int128>(root) * root == square) return root;
  return -1;
}

}  // namespace

Rational::Rational(std::int64_t numerator, std::int64_t denominator) : numerator_(numerator), denominator_(1) {
  if (denominator == 1) return;
  if (denominator == 0) throw FormulaError("a division by zero");
  const auto signed_divisor = static_cast<std::int64_t>(common_divisor(numerator, denominator));
  const std::int64_t divisor =
      signed_divisor < 0 ? -signed_divisor : signed_divisor;  // never 0, since the denominator is not
  const Int128 sign = denominator < 0 ? -1 : 1;
  numerator_ = narrow_to_int64(sign * (numerator / divisor));
  denominator_ = narrow_to_int64(sign * (denominator / divisor));
}

Rational operator+(Rational a, Rational b) {
  if (a.denominator_ == b.denominator_) return reduce_fraction(Int128{a.numerator_} + b.numerator_, a.denominator_);
  const Int128 divisor = common_divisor(a.denominator_, b.denominator_);
  const Int128 left = a.denominator_ / divisor, right = b.denominator_ / divisor;
  return reduce_fraction(a.numerator_ * right + b.numerator_ * left, a.denominator_ * right);
}

Rational operator*(Rational a, Rational b) {
  return reduce_fraction(Int128{a.numerator_} * b.numerator_, Int128{a.denominator_} * b.denominator_);
}

bool operator<(Rational a, Rational b) {
  return Int128{a.numerator()} * b.denominator() < Int128{b.numerator()} * a.denominator();
}

Rational Rational::parse(const std::string& text) {
  std::size_t position = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (negative || (!text.empty() && text[0] == '+')) ++position;
  Rational value;
  int decimal_places = 0;
  bool has_digits = false, is_fraction = false;
  for (; position < text.size() &&
         (std::isdigit(static_cast<unsigned char>(text[position])) != 0 || (text[position] == '.' && !is_fraction));
       ++position) {
    if (text[position] == '.') {
      is_fraction = true;
      continue;
    }
    has_digits = true;
    value = value * Rational(10) + Rational(text[position] - '0');
    if (is_fraction) ++decimal_places;
  }
  long exponent = 0;
  if (has_digits && position < text.size() && (text[position] == 'e' || text[position] == 'E')) {
    char* end = nullptr;
    exponent = std::strtol(text.c_str() + position + 1, &end, 10);
    position = static_cast<std::size_t>(end - text.c_str());
  }
  if (!has_digits || position != text.size()) throw FormulaError("'" + text + "' is not a number");
  if (std::labs(exponent) > 100) throw FormulaError("a coefficient is too long to be exact");
  for (long k = exponent - decimal_places; k > 0; --k) value = value * Rational(10);
  for (long k = exponent - decimal_places; k < 0; ++k) value = value / Rational(10);
  return negative ? -value : value;
}

Rational rational_square_root(Rational square) {
  const std::int64_t numerator_root = integer_square_root(square.numerator()),
                     denominator_root = integer_square_root(square.denominator());
  return numerator_root < 0 || denominator_root < 0 ? Rational() : Rational(numerator_root, denominator_root);
}

}  // namespace balance::formulas
