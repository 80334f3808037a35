#pragma once
/// Polynomials with complex coefficients in the free lengths of a linkage.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/expression/expression.hpp"

#include <complex>
#include <map>
#include <optional>
#include <vector>

namespace balance::certificate {

class LengthPolynomial {
 public:
  using Exponents = std::vector<int>;  ///< one per variable
  using Coefficient = std::complex<double>;

  LengthPolynomial() = default;
  static LengthPolynomial constant(int variables, Coefficient value);
  static LengthPolynomial variable(int variables, int index);

  const std::map<Exponents, Coefficient>& terms() const { return terms_; }
  bool is_zero() const { return terms_.empty(); }
  /// The value of a polynomial without variables (zero included); none if there are variables.
  std::optional<Coefficient> constant_value() const;
  bool has_variable(int index) const;

  LengthPolynomial& operator+=(const LengthPolynomial& other);
  friend LengthPolynomial operator+(LengthPolynomial a, const LengthPolynomial& b) { return a += b; }
  friend LengthPolynomial operator-(const LengthPolynomial& a) { return a * Coefficient(-1); }
  friend LengthPolynomial operator-(LengthPolynomial a, const LengthPolynomial& b) { return a += -b; }
  friend LengthPolynomial operator*(const LengthPolynomial& a, const LengthPolynomial& b);
  friend LengthPolynomial operator*(const LengthPolynomial& a, Coefficient factor);

  LengthPolynomial real() const;
  LengthPolynomial conjugate() const;
  LengthPolynomial derivative(int index) const;
  Coefficient evaluate(const VectorX& lengths) const;
  LengthPolynomial substitute(int index, const LengthPolynomial& value) const;
  /// The quotient; none if it is not a polynomial. Remainders by round-off are ignored.
  std::optional<LengthPolynomial> divide(const LengthPolynomial& divisor) const;

 private:
  void add(const Exponents& exponents, Coefficient coefficient);

  std::map<Exponents, Coefficient> terms_;
};

inline constexpr LengthPolynomial::Coefficient imaginary_unit(0, 1);

/// A polynomial p = unit · size, where `size` has real coefficients and `unit` is a complex number of magnitude 1.
struct PolarForm {
  LengthPolynomial::Coefficient unit = 1;
  LengthPolynomial size;
};
/// None if the argument of p varies with the lengths by more than round-off, or p is zero.
std::optional<PolarForm> find_polar_form(const LengthPolynomial& p);

/// Every node of a graph as a polynomial of the given values of its inputs; none where it is no polynomial (sums,
/// products, integer powers, quotients by monomials).
std::vector<std::optional<LengthPolynomial>> evaluate_polynomials(const expression::ExpressionGraph& graph,
                                                                  int variables,
                                                                  const std::vector<LengthPolynomial>& inputs);

}  // namespace balance::certificate
