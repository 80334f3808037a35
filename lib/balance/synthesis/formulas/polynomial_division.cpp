#include "balance/synthesis/formulas/polynomial_division.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace balance::formulas {

namespace {

/// Longer products of lengths are not searched for common divisors, which would take seconds.
constexpr std::size_t max_divisor_terms = 4000;

bool is_number(const Polynomial& p) {
  return p.size() == 1 && p.terms()[0].monomial.is_one() && p.terms()[0].wave == 0;
}

bool has_negative_exponents(const Monomial& m) {
  for (int k = 0; k < m.size(); ++k)
    if (m.exponent(k) < 0) return true;
  return false;
}

/// The smaller power of each symbol.
Monomial common_monomial(const Monomial& a, const Monomial& b) {
  Monomial shared;
  for (int i = 0, j = 0; i < a.size() || j < b.size();) {
    const bool left = j == b.size() || (i < a.size() && a.symbol(i) <= b.symbol(j));
    const bool right = i == a.size() || (j < b.size() && b.symbol(j) <= a.symbol(i));
    shared.append(left ? a.symbol(i) : b.symbol(j), std::min(left ? a.exponent(i) : 0, right ? b.exponent(j) : 0));
    i += left ? 1 : 0;
    j += right ? 1 : 0;
  }
  return shared;
}

/// The lowest power of every symbol that occurs with a negative exponent.
Monomial negative_powers(const Polynomial& p) {
  Monomial lowest;
  for (const Term& term : p.terms()) lowest = common_monomial(lowest, term.monomial);
  return lowest;
}

Polynomial power_of(const Polynomial& p, int symbol, int exponent) {
  return multiplied_by(p, exponent == 0 ? Monomial() : Monomial(symbol, exponent));
}

struct Content {
  Polynomial common, rest;  ///< p = common · rest
};

/// The common divisor of the coefficients of a symbol's powers.
Content content_in(const Polynomial& p, int symbol) {
  Polynomial common;
  for (const auto& [exponent, coefficient] : coefficients_of(p, symbol)) {
    common = common.is_zero() ? with_coprime_coefficients(coefficient) : greatest_common_divisor(common, coefficient);
    if (is_number(common)) return {1, p};
  }
  if (const auto rest = divide_exactly(p, common)) return {common, *rest};
  return {1, p};
}

/// Remainder of leading^k · a divided by b, as polynomials in one symbol.
Polynomial pseudo_remainder(Polynomial a, const Polynomial& b, int symbol) {
  const int degree = degree_in(b, symbol);
  const Polynomial leading = coefficients_of(b, symbol).rbegin()->second;
  while (!a.is_zero() && degree_in(a, symbol) >= degree) {
    const auto [top, coefficient] = *coefficients_of(a, symbol).rbegin();
    if (a.size() * leading.size() > max_divisor_terms) throw FormulaError("a common divisor takes too long");
    a = leading * a - power_of(coefficient * b, symbol, top - degree);
  }
  return a;
}

Polynomial primitive_divisor(Polynomial a, Polynomial b, int symbol) {
  if (degree_in(a, symbol) < degree_in(b, symbol)) std::swap(a, b);
  while (!b.is_zero()) {
    if (degree_in(b, symbol) == 0) return 1;
    Polynomial remainder = pseudo_remainder(a, b, symbol);
    a = std::move(b);
    b = remainder.is_zero() ? remainder : with_coprime_coefficients(content_in(remainder, symbol).rest);
  }
  return with_coprime_coefficients(a);
}

/// Of polynomials that no symbol divides.
Polynomial divisor_without_monomials(const Polynomial& a, const Polynomial& b) {
  if (is_number(a) || is_number(b)) return 1;
  const std::vector<int> of_a = symbols_in(a), of_b = symbols_in(b);
  const auto other = [](const std::vector<int>& list, const std::vector<int>& than) {
    for (const int s : list)
      if (!std::binary_search(than.begin(), than.end(), s)) return s;
    return -1;
  };
  // a divisor cannot depend on a symbol that only one of them has
  if (const int s = other(of_a, of_b); s >= 0) return greatest_common_divisor(content_in(a, s).common, b);
  if (const int s = other(of_b, of_a); s >= 0) return greatest_common_divisor(a, content_in(b, s).common);
  const int symbol = *std::min_element(of_a.begin(), of_a.end(), [&](int s, int t) {
    return std::max(degree_in(a, s), degree_in(b, s)) < std::max(degree_in(a, t), degree_in(b, t));
  });
  const Content in_a = content_in(a, symbol), in_b = content_in(b, symbol);
  return with_coprime_coefficients(greatest_common_divisor(in_a.common, in_b.common) *
                                   primitive_divisor(in_a.rest, in_b.rest, symbol));
}

}  // namespace

std::map<int, Polynomial> coefficients_of(const Polynomial& p, int symbol) {
  std::map<int, std::vector<Term>> terms;
  for (const Term& term : p.terms()) {
    const Monomial rest = term.monomial.select([symbol](int s, int) { return s != symbol; });
    terms[term.monomial.exponent_of(symbol)].push_back({rest, term.wave, term.coefficient});
  }
  std::map<int, Polynomial> coefficients;
  for (auto& [exponent, list] : terms) coefficients[exponent] = Polynomial::of_terms(p.ring(), std::move(list));
  return coefficients;
}

int degree_in(const Polynomial& p, int symbol) {
  int degree = 0;
  for (const Term& term : p.terms()) degree = std::max(degree, term.monomial.exponent_of(symbol));
  return degree;
}

std::vector<int> symbols_in(const Polynomial& p) {
  std::vector<int> symbols;
  for (const Term& term : p.terms())
    for (int k = 0; k < term.monomial.size(); ++k) symbols.push_back(term.monomial.symbol(k));
  std::sort(symbols.begin(), symbols.end());
  symbols.erase(std::unique(symbols.begin(), symbols.end()), symbols.end());
  return symbols;
}

Monomial common_monomial(const Polynomial& p) {
  Monomial common = p.terms().at(0).monomial;
  for (const Term& term : p.terms()) common = common_monomial(common, term.monomial);
  return common;
}

Polynomial multiplied_by(const Polynomial& p, const Monomial& monomial, Rational factor) {
  std::vector<Term> terms;
  for (const Term& term : p.terms()) terms.push_back({term.monomial * monomial, term.wave, term.coefficient * factor});
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

Polynomial with_coprime_coefficients(const Polynomial& p) {
  std::int64_t numerator = 0;
  Rational denominator = 1;
  for (const Term& term : p.terms()) {
    numerator = std::gcd(numerator, term.coefficient.numerator());
    const std::int64_t d = term.coefficient.denominator();
    // least common multiple, with the overflow of fractions
    denominator = denominator * Rational(d / std::gcd(d, denominator.numerator()), 1);
  }
  if (numerator == 0) return p;
  const int sign = p.terms()[0].coefficient.sign();
  return multiplied_by(p, {}, Rational(sign) * denominator / Rational(numerator, 1));
}

std::optional<Polynomial> divide_exactly(const Polynomial& dividend, const Polynomial& divisor) {
  if (dividend.is_zero()) return dividend;
  if (divisor.size() == 1) {
    const Term& only = divisor.terms()[0];
    Polynomial quotient = multiplied_by(dividend, only.monomial.inverse(), Rational(1) / only.coefficient);
    for (const Term& term : quotient.terms())
      if (has_negative_exponents(term.monomial)) return std::nullopt;
    return quotient;
  }
  const int symbol = symbols_in(divisor).front();
  const auto [degree, leading] = *coefficients_of(divisor, symbol).rbegin();
  Polynomial rest = dividend, quotient;
  while (!rest.is_zero()) {
    const auto [top, coefficient] = *coefficients_of(rest, symbol).rbegin();
    if (top < degree) return std::nullopt;
    const auto factor = divide_exactly(coefficient, leading);
    if (!factor) return std::nullopt;
    const Polynomial part = power_of(*factor, symbol, top - degree);
    quotient += part;
    rest -= part * divisor;
  }
  return quotient;
}

Polynomial greatest_common_divisor(const Polynomial& a, const Polynomial& b) try {
  const Monomial of_a = common_monomial(a), of_b = common_monomial(b), shared = common_monomial(of_a, of_b);
  return Polynomial::of_terms(a.ring() != nullptr ? a.ring() : b.ring(), {{shared, 0, 1}}) *
         divisor_without_monomials(multiplied_by(a, of_a.inverse()), multiplied_by(b, of_b.inverse()));
} catch (const FormulaError&) {
  return 1;
}

namespace {

void add_factor(const Polynomial& factor, std::vector<Polynomial>& factors) {
  if (is_number(factor)) return;
  Polynomial normalised = with_coprime_coefficients(factor);
  if (std::find(factors.begin(), factors.end(), normalised) == factors.end()) factors.push_back(std::move(normalised));
}

/// @param p with no symbol as a factor
void split_into_factors(const Polynomial& p, const std::vector<Polynomial>& known, std::vector<Polynomial>& factors) {
  if (is_number(p)) return;
  for (const Polynomial& factor : known) {
    if (is_number(factor)) continue;
    const auto rest = divide_exactly(p, factor);
    if (!rest) continue;
    add_factor(factor, factors);
    return split_into_factors(*rest, known, factors);
  }
  for (const int symbol : symbols_in(p)) {
    for (const Polynomial& divisor :
         {content_in(p, symbol).common, greatest_common_divisor(p, derivative_by_symbol(p, symbol))}) {
      const auto rest = is_number(divisor) ? std::nullopt : divide_exactly(p, divisor);
      if (!rest || is_number(*rest)) continue;
      split_into_factors(divisor, known, factors);
      return split_into_factors(*rest, known, factors);
    }
  }
  add_factor(p, factors);
}

}  // namespace

std::vector<Polynomial> list_factors(const Polynomial& p, const std::vector<Polynomial>& known) {
  if (p.is_zero()) return {p};
  std::vector<Polynomial> factors;
  const Monomial common = common_monomial(p);
  for (int k = 0; k < common.size(); ++k) factors.push_back(Polynomial::of_symbol(*p.ring(), common.symbol(k)));
  std::vector<Polynomial> sums;
  for (const Polynomial& factor : known)
    if (factor.size() > 1) sums.push_back(factor);
  split_into_factors(multiplied_by(p, common.inverse()), sums, factors);
  return factors;
}

RationalFunction::RationalFunction(Polynomial over, Polynomial under)
    : numerator(std::move(over)), denominator(std::move(under)) {
  if (denominator.is_zero()) throw FormulaError("a denominator vanishes");
  const Monomial cleared = common_monomial(negative_powers(numerator), negative_powers(denominator)).inverse();
  if (!cleared.is_one()) {
    Ring* ring = numerator.ring() != nullptr ? numerator.ring() : denominator.ring();
    const Polynomial unit = Polynomial::of_terms(ring, {{cleared, 0, 1}});
    numerator = unit * numerator, denominator = unit * denominator;
  }
  if (numerator.is_zero()) {
    denominator = 1;
    return;
  }
  Polynomial common = denominator;
  for (const auto& [wave, coefficient] : group_by_trigonometric(numerator))
    if (!is_number(common)) common = greatest_common_divisor(common, coefficient);
  if (!is_number(common)) {
    std::vector<Term> terms;
    for (const auto& [wave, coefficient] : group_by_trigonometric(numerator)) {
      const auto quotient = divide_exactly(coefficient, common);
      if (!quotient) throw FormulaError("a common divisor does not divide");
      for (const Term& term : quotient->terms()) terms.push_back({term.monomial, wave, term.coefficient});
    }
    numerator = Polynomial::of_terms(numerator.ring(), std::move(terms));
    denominator = divide_exactly(denominator, common).value();
  }
  const Polynomial coprime = with_coprime_coefficients(denominator);
  numerator = multiplied_by(numerator, {}, coprime.terms()[0].coefficient / denominator.terms()[0].coefficient);
  denominator = coprime;
}

RationalFunction substitute(const Polynomial& p, int symbol, const RationalFunction& value) {
  const auto coefficients = coefficients_of(p, symbol);
  if (coefficients.empty() || (coefficients.size() == 1 && coefficients.contains(0))) return {p, 1};
  const int lowest = std::min(coefficients.begin()->first, 0), highest = std::max(coefficients.rbegin()->first, 0);
  // numerator^−lowest · denominator^highest · p
  if (lowest < 0 && value.is_zero()) throw FormulaError("a denominator vanishes");
  Polynomial sum;
  for (const auto& [exponent, coefficient] : coefficients)
    sum += coefficient * power(value.numerator, exponent - lowest) * power(value.denominator, highest - exponent);
  return {sum, power(value.numerator, -lowest) * power(value.denominator, highest)};
}

RationalFunction substitute(const RationalFunction& f, int symbol, const RationalFunction& value) {
  const RationalFunction over = substitute(f.numerator, symbol, value),
                         under = substitute(f.denominator, symbol, value);
  if (under.is_zero()) throw FormulaError("a denominator vanishes");
  return {over.numerator * under.denominator, over.denominator * under.numerator};
}

std::optional<Polynomial> as_polynomial(const RationalFunction& f) {
  if (f.denominator.size() != 1) return std::nullopt;
  return f.numerator * power(f.denominator, -1);
}

}  // namespace balance::formulas
