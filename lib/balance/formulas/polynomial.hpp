#pragma once
/// Sums of: fraction · product of powers of symbols · wave. One form for every function, see ring.hpp.

#include "balance/formulas/monomial.hpp"
#include "balance/formulas/ring.hpp"

#include <functional>
#include <map>
#include <vector>

namespace balance::formulas {

struct Term {
  Monomial monomial;
  TrigonometricId wave = 0;
  Rational coefficient;
};

class Polynomial {
 public:
  /// More are refused, so that no mechanism takes all memory.
  static constexpr std::size_t max_terms = 400'000;

  Polynomial() = default;
  Polynomial(int whole) : Polynomial(Rational(whole)) {}  // NOLINT(google-explicit-constructor)
  Polynomial(Rational number);                            // NOLINT(google-explicit-constructor)
  /// symbol^exponent.
  static Polynomial of_symbol(Ring& ring, int symbol, int exponent = 1);
  /// cos or sin of an angle.
  static Polynomial of_angle(Ring& ring, int angle, bool sine);
  /// Terms in any order, some perhaps alike.
  static Polynomial of_terms(Ring* ring, std::vector<Term> terms);

  const std::vector<Term>& terms() const { return terms_; }
  std::size_t size() const { return terms_.size(); }
  bool is_zero() const { return terms_.empty(); }
  /// Null for a plain number.
  Ring* ring() const { return ring_; }

  Polynomial operator-() const;
  Polynomial& operator+=(const Polynomial& other);
  Polynomial& operator-=(const Polynomial& other) { return *this += -other; }
  friend Polynomial operator+(Polynomial a, const Polynomial& b) { return a += b; }
  friend Polynomial operator-(Polynomial a, const Polynomial& b) { return a -= b; }
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);
  friend bool operator==(const Polynomial& a, const Polynomial& b);

 private:
  Ring* ring_ = nullptr;
  std::vector<Term> terms_;  ///< ascending, none alike, no factor zero
};

Polynomial derivative_by_angle(const Polynomial& p, int angle);
Polynomial derivative_by_symbol(const Polynomial& p, int symbol);
/// Powers from 0 on; negative ones of a single term without a wave. @throws FormulaError for others
Polynomial power(const Polynomial& base, int exponent);
/// The symbol's place taken by a value. @throws FormulaError if it is divided by a value of several terms
Polynomial substitute(const Polynomial& p, int symbol, const Polynomial& value);

/// Its value where symbols and angles have these values.
double evaluate_polynomial(const Polynomial& p, const std::vector<double>& symbols, const std::vector<double>& angles);
/// With the values that the ring's symbols and angles have.
double evaluate_polynomial(const Polynomial& p);

/// Every wave and the polynomial of symbols before it, by the wave's number.
std::map<TrigonometricId, Polynomial> group_by_trigonometric(const Polynomial& p);
/// Terms by a part of their monomial, divided by it.
std::map<Monomial, Polynomial> group_by_part(const Polynomial& p, const std::function<Monomial(const Term&)>& part);

}  // namespace balance::formulas
