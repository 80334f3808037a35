#include "balance/synthesis/certificate/length_polynomial.hpp"

#include "balance/foundation/expression/expression_evaluation.hpp"

#include <algorithm>
#include <cmath>

namespace balance::certificate {
namespace {

constexpr int max_power = 8;
/// Expressions with more terms have no use here: a node program would have too many coefficients.
constexpr std::size_t max_terms = 400;
/// Relative to the largest coefficient: what is left of one that cancels.
constexpr double argument_tolerance = 1e-14;
/// Relative to what is added up in a term.
constexpr double remainder_tolerance = 1e-14;

using OptionalPolynomial = std::optional<LengthPolynomial>;

/// Whether an exponent is a small non-negative integer.
std::optional<int> find_power(const OptionalPolynomial& exponent) {
  const auto value = exponent->constant_value();
  if (!value || value->real() != std::floor(value->real()) || value->real() < 0 || value->real() > max_power) return {};
  return static_cast<int>(value->real());
}

struct PolynomialAlgebra {
  using Value = OptionalPolynomial;
  int variables = 0;

  Value constant(double value) const { return LengthPolynomial::constant(variables, value); }

  Value apply(const expression::ExpressionNode& node, const Value& a, const Value& b, const Value& c) const {
    if (!a || !b || !c) return {};
    Value result = combine(node, *a, *b, b);
    if (!result) result = fold(node, *a, *b, *c);
    if (result && result->terms().size() > max_terms) result.reset();
    return result;
  }

 private:
  Value combine(const expression::ExpressionNode& node, const LengthPolynomial& a, const LengthPolynomial& b,
                const Value& exponent) const {
    switch (node.operation) {
      case expression::Operation::alias: return a;
      case expression::Operation::add: return a + b;
      case expression::Operation::subtract: return a - b;
      case expression::Operation::multiply: return a * b;
      case expression::Operation::divide: return b.is_zero() ? Value() : a.divide(b);
      case expression::Operation::negate: return -a;
      case expression::Operation::power: {
        const auto n = find_power(exponent);
        if (!n || a.constant_value()) return {};
        LengthPolynomial product = LengthPolynomial::constant(variables, 1);
        for (int i = 0; i < *n; ++i) {
          product = product * a;
          if (product.terms().size() > max_terms) return {};
        }
        return product;
      }
      default: return {};
    }
  }

  /// Any operation of constants.
  Value fold(const expression::ExpressionNode& node, const LengthPolynomial& a, const LengthPolynomial& b,
             const LengthPolynomial& c) const {
    const auto x = a.constant_value(), y = b.constant_value(), z = c.constant_value();
    if (!x || !y || !z) return {};
    const double value = expression::ScalarAlgebra<double>().apply(node, x->real(), y->real(), z->real());
    return std::isfinite(value) ? constant(value) : Value();
  }
};

}  // namespace

LengthPolynomial LengthPolynomial::constant(int variables, Coefficient value) {
  LengthPolynomial p;
  p.add(Exponents(static_cast<std::size_t>(variables), 0), value);
  return p;
}

LengthPolynomial LengthPolynomial::variable(int variables, int index) {
  Exponents exponents(static_cast<std::size_t>(variables), 0);
  exponents[static_cast<std::size_t>(index)] = 1;
  LengthPolynomial p;
  p.add(exponents, 1);
  return p;
}

std::optional<LengthPolynomial::Coefficient> LengthPolynomial::constant_value() const {
  if (terms_.empty()) return Coefficient(0);
  const auto& [exponents, coefficient] = *terms_.begin();
  const bool is_plain = std::all_of(exponents.begin(), exponents.end(), [](int e) { return e == 0; });
  return terms_.size() == 1 && is_plain ? std::optional(coefficient) : std::nullopt;
}

bool LengthPolynomial::has_variable(int index) const {
  return std::any_of(terms_.begin(), terms_.end(),
                     [index](const auto& term) { return term.first[static_cast<std::size_t>(index)] > 0; });
}

void LengthPolynomial::add(const Exponents& exponents, Coefficient coefficient) {
  Coefficient& sum = terms_[exponents];
  sum += coefficient;
  if (sum == Coefficient(0)) terms_.erase(exponents);
}

LengthPolynomial& LengthPolynomial::operator+=(const LengthPolynomial& other) {
  for (const auto& [exponents, coefficient] : other.terms_) add(exponents, coefficient);
  return *this;
}

LengthPolynomial operator*(const LengthPolynomial& a, const LengthPolynomial& b) {
  LengthPolynomial product;
  for (const auto& [x, u] : a.terms_)
    for (const auto& [y, v] : b.terms_) {
      LengthPolynomial::Exponents sum = x;
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += y[i];
      product.add(sum, u * v);
    }
  return product;
}

LengthPolynomial operator*(const LengthPolynomial& a, LengthPolynomial::Coefficient factor) {
  LengthPolynomial product;
  for (const auto& [exponents, coefficient] : a.terms_) product.add(exponents, coefficient * factor);
  return product;
}

LengthPolynomial LengthPolynomial::real() const {
  LengthPolynomial result;
  for (const auto& [exponents, coefficient] : terms_) result.add(exponents, coefficient.real());
  return result;
}

LengthPolynomial LengthPolynomial::conjugate() const {
  LengthPolynomial result;
  for (const auto& [exponents, coefficient] : terms_) result.add(exponents, std::conj(coefficient));
  return result;
}

LengthPolynomial LengthPolynomial::derivative(int index) const {
  LengthPolynomial result;
  for (const auto& [exponents, coefficient] : terms_) {
    const int power = exponents[static_cast<std::size_t>(index)];
    if (power == 0) continue;
    Exponents reduced = exponents;
    --reduced[static_cast<std::size_t>(index)];
    result.add(reduced, coefficient * static_cast<double>(power));
  }
  return result;
}

LengthPolynomial::Coefficient LengthPolynomial::evaluate(const VectorX& lengths) const {
  Coefficient sum = 0;
  for (const auto& [exponents, coefficient] : terms_) {
    Coefficient product = coefficient;
    for (std::size_t i = 0; i < exponents.size(); ++i)
      for (int e = 0; e < exponents[i]; ++e) product *= lengths[static_cast<Eigen::Index>(i)];
    sum += product;
  }
  return sum;
}

LengthPolynomial LengthPolynomial::substitute(int index, const LengthPolynomial& value) const {
  LengthPolynomial result;
  for (const auto& [exponents, coefficient] : terms_) {
    Exponents others = exponents;
    others[static_cast<std::size_t>(index)] = 0;
    LengthPolynomial term;
    term.add(others, coefficient);
    for (int e = 0; e < exponents[static_cast<std::size_t>(index)]; ++e) term = term * value;
    result += term;
  }
  return result;
}

std::optional<LengthPolynomial> LengthPolynomial::divide(const LengthPolynomial& divisor) const {
  if (divisor.is_zero()) return {};
  const auto& [first, leading] = *divisor.terms_.rbegin();
  std::map<Exponents, double> magnitudes;  // of what is added up in each remaining term
  for (const auto& [exponents, coefficient] : terms_) magnitudes[exponents] = std::abs(coefficient);
  // long division, in the lexicographic order of the terms
  LengthPolynomial quotient, rest = *this;
  while (!rest.is_zero()) {
    const auto [exponents, coefficient] = *rest.terms_.rbegin();
    rest.terms_.erase(exponents);
    if (std::abs(coefficient) <= remainder_tolerance * magnitudes[exponents]) continue;
    Exponents difference = exponents;
    for (std::size_t i = 0; i < first.size(); ++i) {
      difference[i] -= first[i];
      if (difference[i] < 0) return {};
    }
    const Coefficient ratio = coefficient / leading;
    quotient.add(difference, ratio);
    if (quotient.terms_.size() > max_terms) return {};
    for (auto term = std::next(divisor.terms_.rbegin()); term != divisor.terms_.rend(); ++term) {
      Exponents sum = term->first;
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += difference[i];
      rest.add(sum, -term->second * ratio);
      magnitudes[sum] += std::abs(term->second * ratio);
    }
  }
  return quotient;
}

std::optional<PolarForm> find_polar_form(const LengthPolynomial& p) {
  LengthPolynomial::Coefficient largest = 0;
  for (const auto& [exponents, coefficient] : p.terms())
    if (std::abs(coefficient) > std::abs(largest)) largest = coefficient;
  if (largest == LengthPolynomial::Coefficient(0)) return {};
  PolarForm form;
  // plain signs stay exact
  form.unit = largest.imag() == 0 ? largest.real() < 0 ? -1.0 : 1.0 : largest / std::abs(largest);
  const LengthPolynomial turned = p * std::conj(form.unit);
  for (const auto& [exponents, coefficient] : turned.terms())
    if (std::abs(coefficient.imag()) > argument_tolerance * std::abs(largest)) return {};
  form.size = turned.real();
  return form;
}

std::vector<std::optional<LengthPolynomial>> evaluate_polynomials(const expression::ExpressionGraph& graph,
                                                                  int variables,
                                                                  const std::vector<LengthPolynomial>& inputs) {
  std::vector<OptionalPolynomial> values(inputs.begin(), inputs.end());
  return evaluate(graph, values, PolynomialAlgebra{variables});
}

}  // namespace balance::certificate
