#pragma once
/// Several polynomials of low degree in many variables, kept as a sparse list of terms.

#include "balance/foundation/base/types.hpp"

#include <map>
#include <utility>
#include <vector>

namespace balance::design {

/// A monomial: variables in increasing order with their powers (from 1); empty: the constant.
using Monomial = std::vector<std::pair<int, int>>;

class SparsePolynomial {
 public:
  SparsePolynomial(int variables, int outputs) : variables_(variables), outputs_(outputs) {}

  int variables() const { return variables_; }
  int outputs() const { return outputs_; }

  struct Term {
    Monomial monomial;
    std::vector<std::pair<int, double>> coefficients;  ///< output, its coefficient
  };
  const std::vector<Term>& terms() const { return terms_; }
  void add(Monomial monomial, std::vector<std::pair<int, double>> coefficients);

  /// @param jacobian outputs × variables, or null
  void evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const;

  /// No term of this output has a degree above one.
  bool is_affine(int output) const;
  bool is_affine() const;
  /// A variable that the output depends on.
  bool has_variable(int output, int variable) const;
  /// What the output cannot fall below while all variables stay between −1 and 1.
  double lower_bound(int output) const;

  /// matrix × the outputs. Coefficients that are nothing but round-off of what cancels are left out.
  SparsePolynomial combine(const MatrixX& matrix) const;
  /// The same functions of x = centre + half · u, the variables of size `size`; coefficients that cancel are left out.
  SparsePolynomial substitute(const VectorX& centre, const VectorX& half) const;

 private:
  int variables_, outputs_;
  std::vector<Term> terms_;
};

/// Collects coefficients of monomials together with the size of what was added up, so that round-off is known as such.
class PolynomialBuilder {
 public:
  explicit PolynomialBuilder(int outputs) : outputs_(outputs) {}
  void add(const Monomial& monomial, int output, double coefficient);
  /// @param relative coefficients below this part of what was added up to them are left out
  SparsePolynomial build(int variables, double relative) const;

 private:
  int outputs_;
  std::map<Monomial, std::map<int, std::pair<double, double>>> sums_;
};

}  // namespace balance::design
