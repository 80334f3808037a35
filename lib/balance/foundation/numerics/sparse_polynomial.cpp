#include "balance/foundation/numerics/sparse_polynomial.hpp"

#include <algorithm>
#include <cmath>

namespace balance::numerics {

namespace {

/// Coefficients are fitted to about 1e-13 of their size; smaller results of cancellation are round-off.
constexpr double cancellation_tolerance = 1e-12;

int degree(const Monomial& monomial) {
  int sum = 0;
  for (const auto& [variable, power] : monomial) sum += power;
  return sum;
}

double power(double x, int n) {
  double product = 1;
  for (; n > 0; --n) product *= x;
  return product;
}

/// Product of a monomial's factors, with the factor `skip` differentiated (−1: none).
double product(const Monomial& monomial, const VectorX& u, int skip) {
  double value = 1;
  for (int f = 0; f < static_cast<int>(monomial.size()); ++f) {
    const auto [variable, exponent] = monomial[static_cast<std::size_t>(f)];
    value *= f == skip ? exponent * power(u[variable], exponent - 1) : power(u[variable], exponent);
  }
  return value;
}

}  // namespace

void SparsePolynomial::add(Monomial monomial, std::vector<std::pair<int, double>> coefficients) {
  terms_.push_back({std::move(monomial), std::move(coefficients)});
}

void SparsePolynomial::evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const {
  values.setZero(outputs_);
  if (jacobian != nullptr) jacobian->setZero(outputs_, variables_);
  for (const Term& term : terms_) {
    const double value = product(term.monomial, u, -1);
    for (const auto& [output, coefficient] : term.coefficients) values[output] += coefficient * value;
    if (jacobian == nullptr) continue;
    for (int f = 0; f < static_cast<int>(term.monomial.size()); ++f) {
      const double slope = product(term.monomial, u, f);
      double* column = jacobian->col(term.monomial[static_cast<std::size_t>(f)].first).data();
      for (const auto& [output, coefficient] : term.coefficients) column[output] += coefficient * slope;
    }
  }
}

bool SparsePolynomial::is_affine(int output) const {
  return std::none_of(terms_.begin(), terms_.end(), [&](const Term& term) {
    return degree(term.monomial) > 1 && std::any_of(term.coefficients.begin(), term.coefficients.end(),
                                                    [&](const auto& c) { return c.first == output; });
  });
}

bool SparsePolynomial::is_affine() const {
  return std::all_of(terms_.begin(), terms_.end(), [](const Term& term) { return degree(term.monomial) <= 1; });
}

bool SparsePolynomial::has_variable(int output, int variable) const {
  return std::any_of(terms_.begin(), terms_.end(), [&](const Term& term) {
    return std::any_of(term.monomial.begin(), term.monomial.end(),
                       [&](const auto& f) { return f.first == variable; }) &&
           std::any_of(term.coefficients.begin(), term.coefficients.end(),
                       [&](const auto& c) { return c.first == output; });
  });
}

double SparsePolynomial::lower_bound(int output) const {
  double sum = 0;
  for (const Term& term : terms_)
    for (const auto& [o, coefficient] : term.coefficients) {
      if (o != output) continue;
      const bool even =
          std::all_of(term.monomial.begin(), term.monomial.end(), [](const auto& f) { return f.second % 2 == 0; });
      if (term.monomial.empty())
        sum += coefficient;
      else
        sum -= even ? std::max(0.0, -coefficient) : std::abs(coefficient);
    }
  return sum;
}

SparsePolynomial SparsePolynomial::combine(const MatrixX& matrix) const {
  PolynomialBuilder builder(static_cast<int>(matrix.rows()));
  for (const Term& term : terms_)
    for (const auto& [output, coefficient] : term.coefficients)
      for (int row = 0; row < matrix.rows() && output < matrix.cols(); ++row)
        if (matrix(row, output) != 0) builder.add(term.monomial, row, matrix(row, output) * coefficient);
  return builder.build(variables_, cancellation_tolerance);
}

SparsePolynomial SparsePolynomial::substitute(const VectorX& centre, const VectorX& half_width) const {
  // u = (x − centre) / half_width, factor by factor; a variable whose bounds coincide occurs in no term
  PolynomialBuilder builder(outputs_);
  for (const Term& term : terms_) {
    std::map<Monomial, double> expanded{{{}, 1.0}};
    for (const auto& [variable, exponent] : term.monomial)
      for (int k = 0; k < exponent; ++k) {
        std::map<Monomial, double> next;
        for (const auto& [monomial, value] : expanded) {
          next[monomial] -= value * centre[variable] / half_width[variable];
          Monomial multiplied = monomial;
          if (!multiplied.empty() && multiplied.back().first == variable)
            ++multiplied.back().second;
          else
            multiplied.emplace_back(variable, 1);
          next[multiplied] += value / half_width[variable];
        }
        expanded = std::move(next);
      }
    for (const auto& [monomial, value] : expanded)
      for (const auto& [output, coefficient] : term.coefficients)
        if (value != 0) builder.add(monomial, output, value * coefficient);
  }
  return builder.build(variables_, cancellation_tolerance);
}

void PolynomialBuilder::add(const Monomial& monomial, int output, double coefficient) {
  auto& [sum, magnitude] = sums_[monomial][output];
  sum += coefficient;
  magnitude += std::abs(coefficient);
}

SparsePolynomial PolynomialBuilder::build(int variables, double relative_tolerance) const {
  SparsePolynomial result(variables, outputs_);
  for (const auto& [monomial, coefficients] : sums_) {
    std::vector<std::pair<int, double>> significant;
    for (const auto& [output, entry] : coefficients)
      if (std::abs(entry.first) > relative_tolerance * entry.second) significant.emplace_back(output, entry.first);
    if (!significant.empty()) result.add(monomial, std::move(significant));
  }
  return result;
}

}  // namespace balance::numerics
