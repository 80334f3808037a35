#pragma once
/// Exact division, greatest common divisors and factors of polynomials in symbols, and rational functions of symbols.
///
/// Powers of symbols with negative exponents are cleared first: a polynomial times any product of powers of symbols is
/// the same up to a unit. Common divisors are found by Euclid's algorithm in one symbol after the other, with primitive
/// remainders (Knuth, The Art of Computer Programming 2, section 4.6.1).

#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <map>
#include <optional>
#include <vector>

namespace balance::formulas {

/// The polynomial that multiplies each power of a symbol.
std::map<int, Polynomial> coefficients_of(const Polynomial& p, int symbol);
/// Highest power of a symbol; 0 for the zero polynomial.
int degree_in(const Polynomial& p, int symbol);
/// All symbols, ascending.
std::vector<int> symbols_in(const Polynomial& p);

/// The powers of symbols that all terms share; exponents may be negative.
Monomial common_monomial(const Polynomial& p);
Polynomial multiplied_by(const Polynomial& p, const Monomial& monomial, Rational factor = 1);
/// The same polynomial times a number, so that its coefficients are whole, have no common divisor, and the first is
/// positive.
Polynomial with_coprime_coefficients(const Polynomial& p);

/// The quotient if it is a polynomial. @param divisor not zero, without waves
std::optional<Polynomial> divide_exactly(const Polynomial& dividend, const Polynomial& divisor);
/// With coprime coefficients. One if the computation would take too long or overflow: a common divisor then remains.
/// @param a, b without waves, not zero, exponents not negative
Polynomial greatest_common_divisor(const Polynomial& a, const Polynomial& b);
/// Different factors with coprime coefficients whose powers multiply to p up to a number. Factors that depend on
/// different symbols are separated, repeated ones and `known` ones are found; other products may remain.
std::vector<Polynomial> list_factors(const Polynomial& p, const std::vector<Polynomial>& known = {});

/// numerator / denominator in lowest terms; the denominator has no waves, coprime coefficients and no negative exponents.
struct RationalFunction {
  Polynomial numerator, denominator = 1;

  RationalFunction() = default;
  RationalFunction(Polynomial numerator, Polynomial denominator = 1);  // NOLINT(google-explicit-constructor)
  bool is_zero() const { return numerator.is_zero(); }
};

/// The value with a symbol replaced.
RationalFunction substitute(const Polynomial& p, int symbol, const RationalFunction& value);
RationalFunction substitute(const RationalFunction& f, int symbol, const RationalFunction& value);
/// numerator · denominator^−1 as one polynomial, if the denominator is a single term.
std::optional<Polynomial> as_polynomial(const RationalFunction& f);

}  // namespace balance::formulas
