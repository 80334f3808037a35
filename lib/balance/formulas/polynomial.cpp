#include "balance/formulas/polynomial.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace balance::formulas {

namespace {

bool is_before(const Term& a, const Term& b) { return std::tie(a.monomial, a.wave) < std::tie(b.monomial, b.wave); }
bool is_like_term(const Term& a, const Term& b) { return a.wave == b.wave && a.monomial == b.monomial; }

/// Adds up what is alike in a sorted list.
void combine_like_terms(std::vector<Term>& terms) {
  std::size_t last = 0;
  for (std::size_t k = 0; k < terms.size();) {
    Term sum = terms[k++];
    for (; k < terms.size() && is_like_term(terms[k], sum); ++k)
      sum.coefficient = sum.coefficient + terms[k].coefficient;
    if (sum.coefficient.sign() != 0) terms[last++] = sum;
  }
  terms.resize(last);
}

Ring* common(Ring* a, Ring* b) { return a != nullptr ? a : b; }

}  // namespace

Polynomial::Polynomial(Rational number) {
  if (number.sign() != 0) terms_.push_back({{}, 0, number});
}

Polynomial Polynomial::of_symbol(Ring& ring, int symbol, int exponent) {
  return of_terms(&ring, {{Monomial(symbol, exponent), 0, 1}});
}

Polynomial Polynomial::of_angle(Ring& ring, int angle, bool sine) {
  Rational factor = 1;
  const TrigonometricId wave = ring.canonicalise({{ring.angle(angle).group, sine, {{angle, 1}}}}, factor);
  return of_terms(&ring, {{{}, wave, factor}});
}

Polynomial Polynomial::of_terms(Ring* ring, std::vector<Term> terms) {
  std::sort(terms.begin(), terms.end(), is_before);
  combine_like_terms(terms);
  Polynomial p;
  p.ring_ = ring;
  p.terms_ = std::move(terms);
  return p;
}

Polynomial Polynomial::operator-() const {
  Polynomial negative = *this;
  for (Term& term : negative.terms_) term.coefficient = -term.coefficient;
  return negative;
}

Polynomial& Polynomial::operator+=(const Polynomial& other) {
  ring_ = common(ring_, other.ring_);
  if (other.is_zero()) return *this;
  if (is_zero()) return *this = other, *this;
  std::vector<Term> sum;
  sum.reserve(terms_.size() + other.terms_.size());
  std::merge(terms_.begin(), terms_.end(), other.terms_.begin(), other.terms_.end(), std::back_inserter(sum),
             is_before);
  combine_like_terms(sum);
  terms_ = std::move(sum);
  return *this;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Ring* ring = common(a.ring_, b.ring_);
  if (a.size() * b.size() > Polynomial::max_terms) throw FormulaError("they are too long; a program (--code) is not");
  if (ring != nullptr) ring->count_products(a.size() * b.size());
  std::vector<Term> terms;
  terms.reserve(a.size() * b.size());
  for (const Term& x : a.terms_)
    for (const Term& y : b.terms_) {
      const Monomial monomial = x.monomial * y.monomial;
      const Rational factor = x.coefficient * y.coefficient;
      if (x.wave == 0 || y.wave == 0) {
        terms.push_back({monomial, x.wave == 0 ? y.wave : x.wave, factor});
        continue;
      }
      for (const TrigonometricTerm& part : ring->product(x.wave, y.wave))
        terms.push_back({monomial, part.wave, factor * part.factor});
    }
  return Polynomial::of_terms(ring, std::move(terms));
}

bool operator==(const Polynomial& a, const Polynomial& b) {
  return std::equal(a.terms_.begin(), a.terms_.end(), b.terms_.begin(), b.terms_.end(),
                    [](const Term& x, const Term& y) { return is_like_term(x, y) && x.coefficient == y.coefficient; });
}

Polynomial derivative_by_angle(const Polynomial& p, int angle) {
  std::vector<Term> terms;
  for (const Term& term : p.terms()) {
    if (term.wave == 0) continue;
    const TrigonometricTerm part = p.ring()->derivative(term.wave, angle);
    if (part.factor.sign() != 0) terms.push_back({term.monomial, part.wave, term.coefficient * part.factor});
  }
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

Polynomial derivative_by_symbol(const Polynomial& p, int symbol) {
  std::vector<Term> terms;
  for (const Term& term : p.terms())
    if (const int exponent = term.monomial.exponent_of(symbol); exponent != 0)
      terms.push_back({term.monomial * Monomial(symbol, -1), term.wave, term.coefficient * Rational(exponent)});
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

Polynomial power(const Polynomial& base, int exponent) {
  if (exponent < 0) {
    if (base.size() != 1 || base.terms()[0].wave != 0) throw FormulaError("a division by a sum");
    const Term& term = base.terms()[0];
    return power(Polynomial::of_terms(base.ring(), {{term.monomial.inverse(), 0, Rational(1) / term.coefficient}}),
                 -exponent);
  }
  Polynomial product(1);
  for (int k = 0; k < exponent; ++k) product = product * base;
  return product;
}

Polynomial substitute(const Polynomial& p, int symbol, const Polynomial& value) {
  Polynomial result;
  std::map<int, std::vector<Term>> by_exponent;
  for (const Term& term : p.terms()) {
    const int exponent = term.monomial.exponent_of(symbol);
    const Monomial rest = term.monomial.select([symbol](int other, int) { return other != symbol; });
    by_exponent[exponent].push_back({rest, term.wave, term.coefficient});
  }
  for (auto& [exponent, terms] : by_exponent)
    result += Polynomial::of_terms(p.ring(), std::move(terms)) * power(value, exponent);
  return result;
}

double evaluate_polynomial(const Polynomial& p, const std::vector<double>& symbols, const std::vector<double>& angles) {
  double sum = 0;
  std::map<TrigonometricId, double> waves;
  for (const Term& term : p.terms()) {
    double product = term.coefficient.value();
    for (int k = 0; k < term.monomial.size(); ++k)
      product *= elementary::pow(symbols[static_cast<std::size_t>(term.monomial.symbol(k))], term.monomial.exponent(k));
    const auto [at, fresh] = waves.try_emplace(term.wave, 1.0);
    if (fresh && term.wave != 0)
      for (const CircularFunction& function : p.ring()->wave(term.wave)) {
        double argument = 0;
        for (const auto& [angle, multiple] : function.argument)
          argument += multiple * angles[static_cast<std::size_t>(angle)];
        at->second *= function.is_sine ? elementary::sin(argument) : elementary::cos(argument);
      }
    sum += product * at->second;
  }
  return sum;
}

double evaluate_polynomial(const Polynomial& p) {
  std::vector<double> symbols, angles;
  if (p.ring() != nullptr) {
    for (const Symbol& symbol : p.ring()->symbols()) symbols.push_back(symbol.value);
    for (const Angle& angle : p.ring()->angles()) angles.push_back(angle.value);
  }
  return evaluate_polynomial(p, symbols, angles);
}

std::map<TrigonometricId, Polynomial> group_by_trigonometric(const Polynomial& p) {
  std::map<TrigonometricId, std::vector<Term>> terms;
  for (const Term& term : p.terms()) terms[term.wave].push_back({term.monomial, 0, term.coefficient});
  std::map<TrigonometricId, Polynomial> parts;
  for (auto& [wave, list] : terms) parts[wave] = Polynomial::of_terms(p.ring(), std::move(list));
  return parts;
}

std::map<Monomial, Polynomial> group_by_part(const Polynomial& p, const std::function<Monomial(const Term&)>& part) {
  std::map<Monomial, std::vector<Term>> terms;
  for (const Term& term : p.terms()) {
    const Monomial key = part(term);
    terms[key].push_back({term.monomial / key, term.wave, term.coefficient});
  }
  std::map<Monomial, Polynomial> parts;
  for (auto& [key, list] : terms) parts[key] = Polynomial::of_terms(p.ring(), std::move(list));
  return parts;
}

}  // namespace balance::formulas
