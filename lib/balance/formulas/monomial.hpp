#pragma once
/// A product of powers of symbols.

#include "balance/formulas/rational.hpp"

#include <array>
#include <compare>
#include <cstdint>

namespace balance::formulas {

/// Symbols ascend; exponents from −15 to 15, never 0. Small, since there are thousands of them.
class Monomial {
 public:
  static constexpr int max_factors = 14;

  Monomial() = default;
  /// symbol^exponent. @throws FormulaError if the exponent is too large
  explicit Monomial(int symbol, int exponent = 1) { append(symbol, exponent); }

  int size() const { return size_; }
  bool is_one() const { return size_ == 0; }
  int symbol(int k) const { return factors_[static_cast<std::size_t>(k)] >> 5; }
  int exponent(int k) const { return (factors_[static_cast<std::size_t>(k)] & 31) - 16; }
  /// Of any symbol, 0 for one that does not occur.
  int exponent_of(int symbol) const;

  /// Puts another symbol behind the others. @param exponent 0: nothing happens
  void append(int symbol, int exponent);
  /// The factors whose symbols, or exponents, are chosen.
  template <class Choose>
  Monomial select(Choose&& choose) const {
    Monomial chosen;
    for (int k = 0; k < size_; ++k)
      if (choose(symbol(k), exponent(k))) chosen.append(symbol(k), exponent(k));
    return chosen;
  }
  Monomial inverse() const;

  friend Monomial operator*(const Monomial& a, const Monomial& b);
  friend Monomial operator/(const Monomial& a, const Monomial& b) { return a * b.inverse(); }
  friend auto operator<=>(const Monomial& a,
                          const Monomial& b) = default;  // NOLINT(modernize-use-nullptr): of its own making

 private:
  std::array<std::uint16_t, max_factors> factors_{};
  std::uint16_t size_ = 0;
};

}  // namespace balance::formulas
