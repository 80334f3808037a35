#include "balance/synthesis/certificate/bernstein_form.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::certificate {
namespace {

double binomial(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return std::round(value);
}

double integer_power(double x, int n) {
  double value = 1;
  for (; n > 0; --n) value *= x;
  return value;
}

/// From powers of x to Bernstein coefficients of degree d on [lower, lower + width].
MatrixX conversion(int d, double lower, double width) {
  MatrixX matrix = MatrixX::Zero(d + 1, d + 1);
  for (int i = 0; i <= d; ++i)
    for (int e = 0; e <= d; ++e)
      for (int j = 0; j <= std::min(i, e); ++j)
        matrix(i, e) +=
            binomial(i, j) / binomial(d, j) * binomial(e, j) * integer_power(lower, e - j) * integer_power(width, j);
  return matrix;
}

/// Length of the index space behind an axis.
Eigen::Index stride(const std::vector<int>& degrees, std::size_t axis) {
  Eigen::Index count = 1;
  for (std::size_t a = axis + 1; a < degrees.size(); ++a) count *= degrees[a] + 1;
  return count;
}

void transform_axis(MatrixX& values, const std::vector<int>& degrees, std::size_t axis, const MatrixX& matrix) {
  const Eigen::Index step = stride(degrees, axis), count = degrees[axis] + 1;
  MatrixX fibre(count, values.cols());
  for (Eigen::Index block = 0; block < values.rows(); block += step * count)
    for (Eigen::Index offset = 0; offset < step; ++offset) {
      for (Eigen::Index i = 0; i < count; ++i) fibre.row(i) = values.row(block + offset + i * step);
      fibre = (matrix * fibre).eval();
      for (Eigen::Index i = 0; i < count; ++i) values.row(block + offset + i * step) = fibre.row(i);
    }
}

}  // namespace

std::size_t BernsteinCoefficients::axis(int variable) {
  const auto found = std::find(variables.begin(), variables.end(), variable);
  if (found != variables.end()) return static_cast<std::size_t>(found - variables.begin());
  variables.push_back(variable);
  degrees.push_back(0);
  return variables.size() - 1;
}

template <class Combine>
void BernsteinCoefficients::raise(std::size_t axis, const Combine& combine) {
  const Eigen::Index step = stride(degrees, axis), count = degrees[axis] + 1;
  MatrixX raised(values.rows() / count * (count + 1), values.cols());
  const Eigen::RowVectorXd none = Eigen::RowVectorXd::Zero(values.cols());
  for (Eigen::Index block = 0; block * count * step < values.rows(); ++block)
    for (Eigen::Index offset = 0; offset < step; ++offset)
      for (Eigen::Index i = 0; i <= count; ++i) {
        const Eigen::Index old = block * count * step + offset;
        const Eigen::RowVectorXd here = i < count ? values.row(old + i * step).eval() : none;
        const Eigen::RowVectorXd before = i > 0 ? values.row(old + (i - 1) * step).eval() : none;
        raised.row(block * (count + 1) * step + offset + i * step) =
            combine(here, before, static_cast<double>(i) / static_cast<double>(count));
      }
  values = std::move(raised);
  ++degrees[axis];
}

void BernsteinCoefficients::elevate(std::size_t axis) {
  raise(axis, [](const auto& here, const auto& before, double part) -> Eigen::RowVectorXd {
    return (1 - part) * here + part * before;
  });
}

void BernsteinCoefficients::multiply_by_centred(std::size_t axis) {
  raise(axis, [](const auto& here, const auto& before, double part) -> Eigen::RowVectorXd {
    return (part - 1) * here + part * before;
  });
}

namespace {

/// Degrees per variable.
std::vector<int> highest_exponents(const std::vector<LengthPolynomial>& polynomials) {
  std::vector<int> highest;
  for (const LengthPolynomial& p : polynomials)
    for (const auto& [exponents, coefficient] : p.terms()) {
      (void)coefficient;
      highest.resize(std::max(highest.size(), exponents.size()), 0);
      for (std::size_t i = 0; i < exponents.size(); ++i) highest[i] = std::max(highest[i], exponents[i]);
    }
  return highest;
}

}  // namespace

Eigen::Index count_coefficients(const std::vector<LengthPolynomial>& polynomials) {
  Eigen::Index count = 1;
  for (const int degree : highest_exponents(polynomials)) count *= degree + 1;
  return count;
}

BernsteinForm::BernsteinForm(const std::vector<LengthPolynomial>& polynomials) {
  const std::vector<int> highest = highest_exponents(polynomials);
  for (std::size_t i = 0; i < highest.size(); ++i) {
    if (highest[i] == 0) continue;
    variables_.push_back(static_cast<int>(i));
    degrees_.push_back(highest[i]);
  }
  Eigen::Index size = 1;
  for (const int degree : degrees_) size *= degree + 1;
  powers_ = MatrixX::Zero(size, static_cast<Eigen::Index>(polynomials.size()));
  for (std::size_t p = 0; p < polynomials.size(); ++p)
    for (const auto& [exponents, coefficient] : polynomials[p].terms()) {
      Eigen::Index index = 0;
      for (std::size_t a = 0; a < variables_.size(); ++a)
        index = index * (degrees_[a] + 1) + exponents[static_cast<std::size_t>(variables_[a])];
      powers_(index, static_cast<Eigen::Index>(p)) += coefficient.real();
    }
}

BernsteinCoefficients BernsteinForm::convert(const LengthBox& box) const {
  BernsteinCoefficients result{variables_, degrees_, powers_, {}};
  MatrixX sizes = powers_.cwiseAbs();
  for (std::size_t a = 0; a < variables_.size(); ++a) {
    const double lower = box.lower[variables_[a]], width = box.upper[variables_[a]] - lower;
    transform_axis(result.values, degrees_, a, conversion(degrees_[a], lower, width));
    const Eigen::Index step = stride(degrees_, a), count = degrees_[a] + 1;
    for (Eigen::Index i = 0; i < sizes.rows(); ++i)
      sizes.row(i) *= integer_power(std::abs(lower) + width, static_cast<int>(i / step % count));
  }
  result.magnitudes = sizes.colwise().sum().transpose();
  return result;
}

std::pair<double, double> enclose_range(const LengthPolynomial& p, const LengthBox& box) {
  const BernsteinCoefficients coefficients = BernsteinForm({p}).convert(box);
  const double margin = bernstein_round_off * coefficients.magnitudes[0];
  return {numerics::min_coefficient(coefficients.values) - margin,
          numerics::max_coefficient(coefficients.values) + margin};
}

}  // namespace balance::certificate
