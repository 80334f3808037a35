// Squares: (m2 + m3)², J sin²(θ), m (l1 + l2 cos θ)².

#include "balance/synthesis/formulas/formula_printer.hpp"

#include <algorithm>
#include <cmath>

namespace balance::formulas {

namespace {

/// More terms than this are not tried as the root of a square: their signs are.
constexpr std::size_t max_root_terms = 8;

/// The monomial whose square it is, if all exponents are even.
std::optional<Monomial> half_of(const Monomial& m) {
  Monomial half;
  for (int k = 0; k < m.size(); ++k) {
    if (m.exponent(k) % 2 != 0) return std::nullopt;
    half.append(m.symbol(k), m.exponent(k) / 2);
  }
  return half;
}

/// The signs of a root's terms that make its square p, the first being positive.
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

/// One function of even multiples: cos 2a.
bool is_double(const TrigonometricMonomial& wave) {
  return wave.size() == 1 && !wave[0].is_sine &&
         std::all_of(wave[0].argument.begin(), wave[0].argument.end(), [](auto& a) { return a.second % 2 == 0; });
}

CircularFunction halve_angle(CircularFunction function) {
  for (auto& [angle, multiple] : function.argument) multiple /= 2;
  return function;
}

}  // namespace

std::optional<Polynomial> FormulaPrinter::square_root(const Polynomial& p) const {
  std::vector<Term> root;
  for (const Term& term : p.terms()) {
    const auto half = term.wave == 0 && term.coefficient.sign() > 0 ? half_of(term.monomial) : std::nullopt;
    if (!half) continue;
    if (const Rational size = rational_square_root(term.coefficient); size.sign() > 0) root.push_back({*half, 0, size});
  }
  if (root.size() < 2 || p.size() != root.size() * (root.size() + 1) / 2) return std::nullopt;
  return find_root_signs(sorted(Polynomial::of_terms(p.ring(), root)), p);
}

/// p = g² with waves in g: X² cos(2a) / 2 shows X cos(a) in g; what is left of the constants shows the rest.
std::optional<Polynomial> FormulaPrinter::trigonometric_root(const Polynomial& p) const {
  std::vector<Term> root, still;
  for (const Term& term : p.terms()) {
    if (term.wave == 0) still.push_back(term);
    if (term.wave == 0 || !is_double(ring_->wave(term.wave))) continue;
    const auto half = half_of(term.monomial);
    const Rational size = half ? rational_square_root(Rational(2) * abs(term.coefficient)) : Rational();
    if (size.sign() == 0) continue;
    CircularFunction function = halve_angle(ring_->wave(term.wave)[0]);
    function.is_sine = term.coefficient.sign() < 0;
    Rational one = 1;
    root.push_back({*half, ring_->canonicalise({function}, one), size});
    still.push_back({term.monomial, 0, -abs(term.coefficient)});
  }
  const Polynomial constants = Polynomial::of_terms(ring_, std::move(still));
  for (const Term& term : constants.terms()) {
    const auto half = term.coefficient.sign() > 0 ? half_of(term.monomial) : std::nullopt;
    const Rational size = half ? rational_square_root(term.coefficient) : Rational();
    if (size.sign() == 0) return std::nullopt;
    root.push_back({*half, 0, size});
  }
  return find_root_signs(sorted(Polynomial::of_terms(ring_, root)), p);
}

/// A symbol that stands for text.
Polynomial FormulaPrinter::placeholder(const std::string& text, int exponent) {
  auto known = scratch_.find(text);
  if (known == scratch_.end()) known = scratch_.emplace(text, ring_->add_symbol(text, SymbolKind::alias, 0)).first;
  return Polynomial::of_symbol(*ring_, known->second, exponent);
}

/// Powers of cosines in place of cosines of twice the angle; L (1 − cos²) becomes L sin². @return whether something is gained
bool FormulaPrinter::to_cosine_powers(const Polynomial& p, Polynomial& result) {
  Polynomial powers;
  std::map<int, CircularFunction> cosines;  // by scratch symbol
  for (const Term& term : p.terms()) {
    const Polynomial rest = Polynomial::of_terms(ring_, {{term.monomial, 0, term.coefficient}});
    if (term.wave == 0) {
      powers += rest;
      continue;
    }
    const TrigonometricMonomial wave = ring_->wave(term.wave);
    if (wave.size() != 1 || wave[0].is_sine) return false;
    const bool twice = is_double(wave);
    const CircularFunction function = twice ? halve_angle(wave[0]) : wave[0];
    const Polynomial cosine = placeholder(circular(function), 1);
    cosines[cosine.terms()[0].monomial.symbol(0)] = function;
    powers += twice ? rest * (Polynomial(2) * cosine * cosine - Polynomial(1)) : rest * cosine;
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

/// Grouped by inertial symbols, every group with powers of cosines where that makes it a monomial or a square.
std::optional<FormulaPrinter::Printed> FormulaPrinter::format_squares(const Polynomial& p) {
  const auto inertial = [this](const Term& term) {
    return term.monomial.select([this](int s, int) { return is_inertial(ring_->symbol(s).kind); });
  };
  Polynomial all;
  bool gained = false;
  for (const auto& [key, f] : group_by_part(p, inertial)) {
    const Polynomial one = Polynomial::of_terms(ring_, {{key, 0, 1}});
    Polynomial powers;
    if (const auto root = f.size() > 1 ? trigonometric_root(f) : std::nullopt) {
      gained = true;
      if (root->size() == 1) {
        const Term& only = root->terms()[0];
        const Polynomial length = Polynomial::of_terms(ring_, {{only.monomial, 0, only.coefficient}});
        all += one * length * length * placeholder(format_trigonometric(only.wave), 2);
      } else {
        const Printed inner = format(*root, 1);
        all += one * placeholder((style_ == PrintStyle::latex ? "\\left(" : "(") + inner.text +
                                     (style_ == PrintStyle::latex ? "\\right)" : ")"),
                                 2);
      }
    } else if (f.size() > 1 && to_cosine_powers(f, powers)) {
      gained = true;
      all += one * powers;
    } else {
      all += one * f;
    }
  }
  if (!gained) return std::nullopt;
  squares_ = false;
  Printed printed = format_grouped(
      all,
      [&](const Term& term) {
        return Term{inertial(term), 0, 1};
      },
      1);
  squares_ = true;
  return printed;
}

}  // namespace balance::formulas
