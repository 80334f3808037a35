#pragma once
/// Exact fractions. Overflow is an error; values are never rounded.

#include <cstdint>
#include <stdexcept>
#include <string>

namespace balance::formulas {

/// A formula cannot be derived; the message says why, as part of a sentence.
struct FormulaError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// numerator / denominator in lowest terms, the denominator positive.
class Rational {
 public:
  constexpr Rational() = default;
  constexpr Rational(int whole) : numerator_(whole) {}  // NOLINT(google-explicit-constructor)
  /// @throws FormulaError if the denominator is zero or the fraction overflows
  Rational(std::int64_t numerator, std::int64_t denominator);
  /// "12", "-0.35", "1.5e-3", exactly.
  /// @throws FormulaError if the text is no such number or overflows
  static Rational parse(const std::string& text);

  std::int64_t numerator() const { return numerator_; }
  std::int64_t denominator() const { return denominator_; }
  double value() const { return static_cast<double>(numerator_) / static_cast<double>(denominator_); }
  int sign() const { return numerator_ > 0 ? 1 : numerator_ < 0 ? -1 : 0; }
  bool is_integer() const { return denominator_ == 1; }

  Rational operator-() const { return {-numerator_, denominator_}; }
  friend Rational operator+(Rational a, Rational b);
  friend Rational operator-(Rational a, Rational b) { return a + -b; }
  friend Rational operator*(Rational a, Rational b);
  /// @throws FormulaError for division by zero
  friend Rational operator/(Rational a, Rational b) { return a * Rational(b.denominator_, b.numerator_); }
  friend bool operator==(const Rational& a, const Rational& b) = default;

 private:
  std::int64_t numerator_ = 0, denominator_ = 1;
};

inline Rational abs(Rational a) { return a.sign() < 0 ? -a : a; }
bool operator<(Rational a, Rational b);

/// The square root if it is a fraction, otherwise zero.
/// @param square nonnegative
Rational rational_square_root(Rational square);

}  // namespace balance::formulas
