#pragma once
/// Bernstein coefficients of real polynomials on a box: their smallest and largest bound the polynomial there.

#include "balance/synthesis/certificate/length_polynomial.hpp"

#include <utility>

namespace balance::certificate {

/// lower ≤ lengths ≤ upper.
struct LengthBox {
  VectorX lower, upper;

  VectorX middle() const { return (lower + upper) / 2; }
};

/// Bernstein coefficients of several polynomials (columns) with the same degree in every variable, for box coordinates
/// t in [0, 1].
struct BernsteinCoefficients {
  std::vector<int> variables;  ///< in which the degree may be positive
  std::vector<int> degrees;    ///< per variable
  MatrixX values;              ///< coefficients × polynomials; the last variable's index runs fastest
  VectorX magnitudes;          ///< per polynomial: bound on the sums of absolute terms from which its values come

  /// The axis of a variable, which is added with degree 0 if it is missing.
  std::size_t axis(int variable);
  /// Raises the degree along an axis by one.
  void elevate(std::size_t axis);
  /// Multiplies by 2t − 1 along an axis, which raises the degree by one.
  void multiply_by_centred(std::size_t axis);

 private:
  /// The values with one more index along the axis: entry i is made of the old entries i and i − 1.
  template <class Combine>
  void raise(std::size_t axis, const Combine& combine);
};

/// Real polynomials, stored for conversion on many boxes.
class BernsteinForm {
 public:
  explicit BernsteinForm(const std::vector<LengthPolynomial>& polynomials);

  const std::vector<int>& variables() const { return variables_; }
  BernsteinCoefficients convert(const LengthBox& box) const;

 private:
  std::vector<int> variables_, degrees_;
  MatrixX powers_;  ///< as BernsteinCoefficients::values, of the power basis
};

/// Of the form of these polynomials.
Eigen::Index count_coefficients(const std::vector<LengthPolynomial>& polynomials);

/// Relative error of Bernstein coefficients and of sums of their products with multipliers, for the degrees and numbers
/// of terms that occur here: some hundreds of roundings, with a margin.
inline constexpr double bernstein_round_off = 1e-13;

/// Lower and upper bound of the real part of a polynomial on a box.
std::pair<double, double> enclose_range(const LengthPolynomial& p, const LengthBox& box);

}  // namespace balance::certificate
