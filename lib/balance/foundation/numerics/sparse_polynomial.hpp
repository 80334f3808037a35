#pragma once
/// Several polynomials of low degree in many variables, stored as a sparse list of terms.

#include "balance/foundation/base/types.hpp"

#include <map>
#include <utility>
#include <vector>

namespace balance::numerics {

/// A monomial: (variable, power ≥ 1) pairs in increasing order of variables; empty for the constant.
using Monomial = std::vector<std::pair<int, int>>;

class SparsePolynomial {
 public:
  SparsePolynomial(int variables, int outputs) : variables_(variables), outputs_(outputs) {}

  int variables() const { return variables_; }
  int outputs() const { return outputs_; }

  struct Term {
    Monomial monomial;
    std::vector<std::pair<int, double>> coefficients;  ///< (output, coefficient)
  };
  const std::vector<Term>& terms() const { return terms_; }
  void add(Monomial monomial, std::vector<std::pair<int, double>> coefficients);

  /// @param jacobian outputs × variables, or null
  void evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const;

  /// Whether no term of this output has a degree above one.
  bool is_affine(int output) const;
  bool is_affine() const;
  /// Whether the output depends on the variable.
  bool has_variable(int output, int variable) const;
  /// Lower bound of the output while all variables are between −1 and 1.
  double lower_bound(int output) const;

  /// matrix × outputs. Drops coefficients that are only round-off from cancellation.
  SparsePolynomial combine(const MatrixX& matrix) const;
  /// The same functions in terms of x = centre + half_width · u. Drops coefficients that cancel.
  SparsePolynomial substitute(const VectorX& centre, const VectorX& half_width) const;

 private:
  int variables_, outputs_;
  std::vector<Term> terms_;
};

/// Sums coefficients of monomials together with their magnitudes, so that round-off can be recognised.
class PolynomialBuilder {
 public:
  explicit PolynomialBuilder(int outputs) : outputs_(outputs) {}
  void add(const Monomial& monomial, int output, double coefficient);
  /// @param relative_tolerance coefficients below this fraction of their summed magnitudes are dropped
  SparsePolynomial build(int variables, double relative_tolerance) const;

 private:
  int outputs_;
  std::map<Monomial, std::map<int, std::pair<double, double>>> sums_;
};

}  // namespace balance::numerics
