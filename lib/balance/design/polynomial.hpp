#pragma once
/// Several polynomials of low degree in many variables, kept as a sparse list of terms. Private to design.

#include "balance/base/types.hpp"

#include <map>
#include <utility>
#include <vector>

namespace balance::designing {

/// A monomial: variables in increasing order with their powers (from 1); empty: the constant.
using Monomial = std::vector<std::pair<int, int>>;

class Polynomial {
 public:
  Polynomial(int variables, int outputs) : variables_(variables), outputs_(outputs) {}

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
  bool affine(int output) const;
  bool affine() const;
  /// A variable that the output depends on.
  bool touches(int output, int variable) const;
  /// What the output cannot fall below while all variables stay between −1 and 1.
  double least(int output) const;

  /// matrix × the outputs. Coefficients that are nothing but round-off of what cancels are left out.
  Polynomial combined(const MatrixX& matrix) const;
  /// The same functions of x = centre + half · u, the variables of size `size`; coefficients that cancel are left out.
  Polynomial substituted(const VectorX& centre, const VectorX& half) const;

 private:
  int variables_, outputs_;
  std::vector<Term> terms_;
};

/// Collects coefficients of monomials together with the size of what was added up, so that round-off is known as such.
class TermCollector {
 public:
  explicit TermCollector(int outputs) : outputs_(outputs) {}
  void add(const Monomial& monomial, int output, double coefficient);
  /// @param relative coefficients below this part of what was added up to them are left out
  Polynomial finish(int variables, double relative) const;

 private:
  int outputs_;
  std::map<Monomial, std::map<int, std::pair<double, double>>> sums_;
};

}  // namespace balance::designing
