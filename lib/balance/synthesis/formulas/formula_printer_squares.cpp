// Squares: (m2 + m3)², J sin²(θ), m (l1 + l2 cos θ)².

#include "balance/synthesis/formulas/formula_printer.hpp"

#include <algorithm>
#include <cmath>

namespace balance::formulas {

namespace {

/// Roots with more terms are not tried, since all combinations of their signs are.
constexpr std::size_t max_root_terms = 8;

/// The square root of a monomial, if all exponents are even.
std::optional<Monomial> monomial_square_root(const Monomial& m) {
  Monomial root;
  for (int k = 0; k < m.size(); ++k) {
    if (m.exponent(k) % 2 != 0) return std::nullopt;
    root.append(m.symbol(k), m.exponent(k) / 2);
  }
  return root;
}

/// Chooses the signs of a root's terms such that its square is p; the first term is positive.
std::optional<Polynomial> find_root_signs(const std::vector<Term>& root, const Polynomial& p) {
  if (root.empty() || root.size() > max_root_terms) return std::nullopt;
  for (unsigned mask = 0; mask < 1U << (root.size() - 1); ++mask) {
    std::vector<Term> terms = root;
    for (std::size_t i = 1; i < terms.size(); ++i)
      if ((mask >> (i - 1) & 1U) != 0) terms[i].coefficient = -terms[i].coefficient;
    Polynomial signed_root = Polynomial::of_terms(p.ring(), std::move(terms));
    if (signed_root * signed_root == p) return signed_root;
  }
  return std::nullopt;
}

/// Whether a wave is a single cosine of even multiples: cos 2a.
bool is_double(const TrigonometricMonomial& trig) {
  return trig.size() == 1 && !trig[0].is_sine &&
         std::all_of(trig[0].argument.begin(), trig[0].argument.end(), [](auto& a) { return a.second % 2 == 0; });
}

CircularFunction halve_angle(CircularFunction function) {
  for (auto& [angle, multiple] : function.argument) multiple /= 2;
  return function;
}

}  // namespace

std::optional<Polynomial> FormulaPrinter::square_root(const Polynomial& p) const {
  std::vector<Term> root;
  for (const Term& term : p.terms()) {
    const auto half =
        term.wave == 0 && term.coefficient.sign() > 0 ? monomial_square_root(term.monomial) : std::nullopt;
    if (!half) continue;
    if (const Rational size = rational_square_root(term.coefficient); size.sign() > 0) root.push_back({*half, 0, size});
  }
  if (root.size() < 2 || p.size() != root.size() * (root.size() + 1) / 2) return std::nullopt;
  return find_root_signs(sorted(Polynomial::of_terms(p.ring(), root)), p);
}

/// Finds g with waves such that p = g²: X² cos(2a) / 2 indicates X cos(a) in g; the remaining constants, the rest.
std::optional<Polynomial> FormulaPrinter::trigonometric_root(const Polynomial& p) const {
  std::vector<Term> root, constant_terms;
  for (const Term& term : p.terms()) {
    if (term.wave == 0) constant_terms.push_back(term);
    if (term.wave == 0 || !is_double(ring_->wave(term.wave))) continue;
    const auto half = monomial_square_root(term.monomial);
    const Rational size = half ? rational_square_root(Rational(2) * abs(term.coefficient)) : Rational();
    if (size.sign() == 0) continue;
    CircularFunction function = halve_angle(ring_->wave(term.wave)[0]);
    function.is_sine = term.coefficient.sign() < 0;
    Rational sign = 1;
    root.push_back({*half, ring_->canonicalise({function}, sign), size});
    constant_terms.push_back({term.monomial, 0, -abs(term.coefficient)});
  }
  const Polynomial constants = Polynomial::of_terms(ring_, std::move(constant_terms));
  for (const Term& term : constants.terms()) {
    const auto half = term.coefficient.sign() > 0 ? monomial_square_root(term.monomial) : std::nullopt;
    const Rational size = half ? rational_square_root(term.coefficient) : Rational();
    if (size.sign() == 0) return std::nullopt;
    root.push_back({*half, 0, size});
  }
  return find_root_signs(sorted(Polynomial::of_terms(ring_, root)), p);
}

/// A symbol that stands for text.
Polynomial FormulaPrinter::placeholder(const std::string& text, int exponent) {
  auto known = placeholders_.find(text);
  if (known == placeholders_.end())
    known = placeholders_.emplace(text, ring_->add_symbol(text, SymbolKind::alias, 0)).first;
  return Polynomial::of_symbol(*ring_, known->second, exponent);
}

/// Replaces cosines of double angles by powers of cosines; L (1 − cos²) becomes L sin².
/// @return whether this simplifies the expression
bool FormulaPrinter::to_cosine_powers(const Polynomial& p, Polynomial& result) {
  Polynomial powers;
  std::map<int, CircularFunction> cosines;  // by scratch symbol
  for (const Term& term : p.terms()) {
    const Polynomial rest = Polynomial::of_terms(ring_, {{term.monomial, 0, term.coefficient}});
    if (term.wave == 0) {
      powers += rest;
      continue;
    }
    const TrigonometricMonomial trig = ring_->wave(term.wave);
    if (trig.size() != 1 || trig[0].is_sine) return false;
    const bool has_double_angle = is_double(trig);
    const CircularFunction function = has_double_angle ? halve_angle(trig[0]) : trig[0];
    const Polynomial cosine = placeholder(circular(function), 1);
    cosines[cosine.terms()[0].monomial.symbol(0)] = function;
    powers += has_double_angle ? rest * (Polynomial(2) * cosine * cosine - Polynomial(1)) : rest * cosine;
  }
  if (cosines.empty()) return false;
  for (const auto& [symbol, function] : cosines) {
    if (powers.size() != 2) break;
    const Term *a = &powers.terms()[0], *b = &powers.terms()[1];
    if (a->monomial.exponent_of(symbol) == 2) std::swap(a, b);
    if (!(a->monomial * Monomial(symbol, 2) == b->monomial) || !(a->coefficient == -b->coefficient)) continue;
    CircularFunction sine = function;
    sine.is_sine = true;
    powers = Polynomial::of_terms(ring_, {{a->monomial, 0, a->coefficient}}) * placeholder(circular(sine), 2);
  }
  result = powers;
  return powers.size() == 1 || square_root(powers) || powers.size() < p.size();
}

/// Groups by inertial symbols. A group is written with powers of cosines if these make it a monomial or a square.
std::optional<FormulaPrinter::Printed> FormulaPrinter::format_squares(const Polynomial& p) {
  const auto inertial = [this](const Term& term) {
    return term.monomial.select([this](int s, int) { return is_inertial(ring_->symbol(s).kind); });
  };
  Polynomial regrouped;
  bool has_improved = false;
  for (const auto& [key, f] : group_by_part(p, inertial)) {
    const Polynomial group_factor = Polynomial::of_terms(ring_, {{key, 0, 1}});
    Polynomial powers;
    if (const auto root = f.size() > 1 ? trigonometric_root(f) : std::nullopt) {
      has_improved = true;
      if (root->size() == 1) {
        const Term& only = root->terms()[0];
        const Polynomial length = Polynomial::of_terms(ring_, {{only.monomial, 0, only.coefficient}});
        regrouped += group_factor * length * length * placeholder(format_trigonometric(only.wave), 2);
      } else {
        const Printed inner = format(*root, 1);
        regrouped += group_factor * placeholder((style_ == PrintStyle::latex ? "\\left(" : "(") + inner.text +
                                                    (style_ == PrintStyle::latex ? "\\right)" : ")"),
                                                2);
      }
    } else if (f.size() > 1 && to_cosine_powers(f, powers)) {
      has_improved = true;
      regrouped += group_factor * powers;
    } else {
      regrouped += group_factor * f;
    }
  }
  if (!has_improved) return std::nullopt;
  recognises_squares_ = false;
  Printed printed = format_grouped(
      regrouped,
      [&](const Term& term) {
        return Term{inertial(term), 0, 1};
      },
      1);
  recognises_squares_ = true;
  return printed;
}

}  // namespace balance::formulas
