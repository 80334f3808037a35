#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace balance::formulas {

int Monomial::exponent_of(int symbol) const {
  for (int k = 0; k < size_; ++k)
    if (this->symbol(k) == symbol) return exponent(k);
  return 0;
}

void Monomial::append(int symbol, int exponent) {
  if (exponent == 0) return;
  if (exponent < -15 || exponent > 15) throw FormulaError("a power is too high");
  if (size_ == max_factors) throw FormulaError("a product has too many factors");
  factors_[size_++] = static_cast<std::uint16_t>((symbol << 5) | (exponent + 16));
}

Monomial Monomial::inverse() const {
  Monomial result;
  for (int k = 0; k < size_; ++k) result.append(symbol(k), -exponent(k));
  return result;
}

Monomial operator*(const Monomial& a, const Monomial& b) {
  if (a.size_ == 0) return b;
  if (b.size_ == 0) return a;
  Monomial product;
  int i = 0, j = 0;
  while (i < a.size_ || j < b.size_) {
    const bool left = j == b.size_ || (i < a.size_ && a.symbol(i) <= b.symbol(j));
    const bool right = i == a.size_ || (j < b.size_ && b.symbol(j) <= a.symbol(i));
    product.append(left ? a.symbol(i) : b.symbol(j), (left ? a.exponent(i) : 0) + (right ? b.exponent(j) : 0));
    i += left ? 1 : 0;
    j += right ? 1 : 0;
  }
  return product;
}

namespace {

bool is_before(const Term& a, const Term& b) { return std::tie(a.monomial, a.wave) < std::tie(b.monomial, b.wave); }
bool is_like_term(const Term& a, const Term& b) { return a.wave == b.wave && a.monomial == b.monomial; }

/// Combines like terms in a sorted list.
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
  const TrigonometricId trig = ring.canonicalise({{ring.angle(angle).group, sine, {{angle, 1}}}}, factor);
  return of_terms(&ring, {{{}, trig, factor}});
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
  std::map<TrigonometricId, double> trig_values;
  for (const Term& term : p.terms()) {
    double product = term.coefficient.value();
    for (int k = 0; k < term.monomial.size(); ++k)
      product *= elementary::pow(symbols[static_cast<std::size_t>(term.monomial.symbol(k))], term.monomial.exponent(k));
    const auto [entry, is_new] = trig_values.try_emplace(term.wave, 1.0);
    if (is_new && term.wave != 0)
      for (const CircularFunction& function : p.ring()->wave(term.wave)) {
        double argument = 0;
        for (const auto& [angle, multiple] : function.argument)
          argument += multiple * angles[static_cast<std::size_t>(angle)];
        entry->second *= function.is_sine ? elementary::sin(argument) : elementary::cos(argument);
      }
    sum += product * entry->second;
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
  std::map<TrigonometricId, Polynomial> groups;
  for (auto& [trig, list] : terms) groups[trig] = Polynomial::of_terms(p.ring(), std::move(list));
  return groups;
}

std::map<Monomial, Polynomial> group_by_part(const Polynomial& p, const std::function<Monomial(const Term&)>& part) {
  std::map<Monomial, std::vector<Term>> terms;
  for (const Term& term : p.terms()) {
    const Monomial key = part(term);
    terms[key].push_back({term.monomial / key, term.wave, term.coefficient});
  }
  std::map<Monomial, Polynomial> groups;
  for (auto& [key, list] : terms) groups[key] = Polynomial::of_terms(p.ring(), std::move(list));
  return groups;
}

namespace {

/// a + sign · b.
std::vector<std::pair<int, int>> sum_of(const std::vector<std::pair<int, int>>& a,
                                        const std::vector<std::pair<int, int>>& b, int sign) {
  std::vector<std::pair<int, int>> sum;
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    const bool left = j == b.size() || (i < a.size() && a[i].first <= b[j].first);
    const bool right = i == a.size() || (j < b.size() && b[j].first <= a[i].first);
    const int angle = left ? a[i].first : b[j].first;
    const int multiple = (left ? a[i].second : 0) + (right ? sign * b[j].second : 0);
    if (multiple != 0) sum.emplace_back(angle, multiple);
    i += left ? 1 : 0;
    j += right ? 1 : 0;
  }
  return sum;
}

/// One of the two terms into which a product of two circular functions of a group is expanded.
struct ProductToSumTerm {
  CircularFunction function;
  Rational factor;
};

ProductToSumTerm product_to_sum(const CircularFunction& a, const CircularFunction& b, int sign) {
  ProductToSumTerm half{{a.group, a.is_sine != b.is_sine, sum_of(a.argument, b.argument, sign)}, Rational(1, 2)};
  // sin a sin b = (cos(a − b) − cos(a + b)) / 2, cos a sin b = (sin(a + b) − sin(a − b)) / 2
  if ((a.is_sine && b.is_sine && sign > 0) || (!a.is_sine && b.is_sine && sign < 0)) half.factor = Rational(-1, 2);
  return half;
}

}  // namespace

Ring::Ring() : trigonometric_monomials_(1), trigonometric_ids_{{TrigonometricMonomial{}, 0}} {}

bool Ring::has_name(const std::string& name) const {
  const auto is_same_name = [&](const auto& other) { return other.name == name; };
  return std::any_of(symbols_.begin(), symbols_.end(), is_same_name) ||
         std::any_of(angles_.begin(), angles_.end(), is_same_name);
}

int Ring::add_symbol(const std::string& name, SymbolKind kind, const Expression& source) {
  if (static_cast<int>(symbols_.size()) >= max_symbols)
    throw FormulaError("there are more than " + std::to_string(max_symbols) + " symbols");
  std::string unique_name = name;
  while (has_name(unique_name)) unique_name += '_';
  symbols_.push_back({unique_name, kind, source.value(), source});
  return static_cast<int>(symbols_.size()) - 1;
}

int Ring::add_angle(const std::string& name, int group) {
  std::string unique_name = name;
  while (has_name(unique_name)) unique_name += '_';
  angles_.push_back({unique_name, group, false, 0, {}});
  return static_cast<int>(angles_.size()) - 1;
}

int Ring::add_fixed_angle(const std::string& name, int group, const Expression& source) {
  const int angle = add_angle(name, group);
  Angle& fixed = angles_.back();
  fixed.is_fixed = true, fixed.value = source.value(), fixed.source = source;
  return angle;
}

int Ring::symbol_of_angle(int angle) {
  const std::string& name = angles_[static_cast<std::size_t>(angle)].name;
  const auto known =
      std::find_if(symbols_.begin(), symbols_.end(), [&](const Symbol& symbol) { return symbol.name == name; });
  if (known != symbols_.end()) return static_cast<int>(known - symbols_.begin());
  symbols_.push_back({name, SymbolKind::slide, 0, {}});
  return static_cast<int>(symbols_.size()) - 1;
}

TrigonometricId Ring::canonicalise(TrigonometricMonomial trig, Rational& factor) {
  TrigonometricMonomial canonical;
  for (CircularFunction& function : trig) {
    if (function.argument.empty()) {
      if (function.is_sine) factor = Rational(0);
      continue;
    }
    if (function.argument.front().second < 0) {
      for (auto& [angle, multiple] : function.argument) multiple = -multiple;
      if (function.is_sine) factor = -factor;
    }
    canonical.push_back(std::move(function));
  }
  std::sort(canonical.begin(), canonical.end());
  const auto [entry, is_new] =
      trigonometric_ids_.try_emplace(canonical, static_cast<TrigonometricId>(trigonometric_monomials_.size()));
  if (is_new) {
    if (static_cast<int>(trigonometric_monomials_.size()) >= max_trigonometric_monomials)
      throw FormulaError("they are too long; a program (--code) is not");
    trigonometric_monomials_.push_back(std::move(canonical));
  }
  return entry->second;
}

const std::vector<TrigonometricTerm>& Ring::product(TrigonometricId a, TrigonometricId b) {
  if (a > b) std::swap(a, b);
  const auto [entry, is_new] = products_.try_emplace({a, b});
  if (!is_new) return entry->second;
  struct Partial {
    TrigonometricMonomial trig;
    Rational factor = 1;
  };
  std::vector<Partial> partial_products(1), expanded;
  const TrigonometricMonomial left = trigonometric_monomials_[a], right = trigonometric_monomials_[b];
  std::size_t i = 0, j = 0;
  while (i < left.size() || j < right.size()) {
    const bool from_left = j == right.size() || (i < left.size() && left[i].group <= right[j].group);
    const bool from_right = i == left.size() || (j < right.size() && right[j].group <= left[i].group);
    expanded.clear();
    for (Partial& partial : partial_products) {
      if (!(from_left && from_right)) {
        partial.trig.push_back(from_left ? left[i] : right[j]);
        expanded.push_back(partial);
        continue;
      }
      for (const int sign : {1, -1}) {
        const ProductToSumTerm half = product_to_sum(left[i], right[j], sign);
        expanded.push_back(partial);
        expanded.back().trig.push_back(half.function);
        expanded.back().factor = partial.factor * half.factor;
      }
    }
    partial_products.swap(expanded);
    i += from_left ? 1 : 0;
    j += from_right ? 1 : 0;
  }
  for (Partial& partial : partial_products) {
    TrigonometricTerm term{0, partial.factor};
    term.wave = canonicalise(std::move(partial.trig), term.factor);
    if (term.factor.sign() != 0) entry->second.push_back(term);
  }
  return entry->second;
}

TrigonometricTerm Ring::derivative(TrigonometricId trig, int angle) {
  TrigonometricMonomial differentiated = trigonometric_monomials_[trig];
  for (CircularFunction& function : differentiated)
    for (const auto& [variable, multiple] : function.argument)
      if (variable == angle) {
        TrigonometricTerm result{0, function.is_sine ? Rational(multiple) : Rational(-multiple)};
        function.is_sine = !function.is_sine;
        result.wave = canonicalise(std::move(differentiated), result.factor);
        return result;
      }
  return {0, 0};
}

}  // namespace balance::formulas
