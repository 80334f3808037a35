#include "balance/design/second_order_cone.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using Block = SecondOrderCone::Block;

auto tail(const VectorX& x, const Block& block) { return x.segment(block.first + 1, block.size - 1); }

/// The least positive step at which t² − |v|² of x + step · d vanishes.
double block_step(const VectorX& x, const VectorX& d, const Block& block) {
  const double a = cone_determinant(d, block), c = cone_determinant(x, block);
  const double b = x[block.first] * d[block.first] - tail(x, block).dot(tail(d, block));
  const double discriminant = b * b - a * c;
  if (!(a < 0 || (b < 0 && discriminant >= 0))) return infinity;
  const double below = -b + std::sqrt(std::max(discriminant, 0.0));
  return below > 0 ? c / below : infinity;
}

}  // namespace

double cone_determinant(const VectorX& x, const Block& block) {
  const double norm = tail(x, block).norm();
  return (x[block.first] - norm) * (x[block.first] + norm);
}

SecondOrderCone::SecondOrderCone(Eigen::Index linear, const std::vector<Eigen::Index>& sizes)
    : linear_(linear), size_(linear) {
  for (const Eigen::Index size : sizes) {
    blocks_.push_back({size_, size});
    size_ += size;
  }
}

VectorX SecondOrderCone::identity() const {
  VectorX e = VectorX::Zero(size_);
  e.head(linear_).setOnes();
  for (const Block& block : blocks_) e[block.first] = 1;
  return e;
}

VectorX SecondOrderCone::jordan_product(const VectorX& a, const VectorX& b) const {
  VectorX result = a.cwiseProduct(b);
  for (const Block& block : blocks_) {
    const auto rest = block.size - 1;
    result.segment(block.first + 1, rest) = a[block.first] * tail(b, block) + b[block.first] * tail(a, block);
    result[block.first] = a.segment(block.first, block.size).dot(b.segment(block.first, block.size));
  }
  return result;
}

VectorX SecondOrderCone::jordan_quotient(const VectorX& a, const VectorX& b) const {
  VectorX result(size_);
  result.head(linear_) = b.head(linear_).cwiseQuotient(a.head(linear_));
  for (const Block& block : blocks_) {
    const double a0 = a[block.first], b0 = b[block.first];
    const double x0 = (a0 * b0 - tail(a, block).dot(tail(b, block))) / std::max(cone_determinant(a, block), 1e-300);
    result[block.first] = x0;
    result.segment(block.first + 1, block.size - 1) = (tail(b, block) - x0 * tail(a, block)) / a0;
  }
  return result;
}

double SecondOrderCone::min_eigenvalue(const VectorX& x) const {
  double least = min_coefficient(x.head(linear_));
  for (const Block& block : blocks_) least = std::min(least, x[block.first] - tail(x, block).norm());
  return least;
}

double SecondOrderCone::max_step(const VectorX& x, const VectorX& d) const {
  double step = infinity;
  for (Eigen::Index i = 0; i < linear_; ++i)
    if (d[i] < 0) step = std::min(step, -x[i] / d[i]);
  for (const Block& block : blocks_) step = std::min(step, block_step(x, d, block));
  return step;
}

NesterovToddScaling::NesterovToddScaling(const SecondOrderCone& cone, const VectorX& s, const VectorX& z)
    : cone_(cone),
      diagonal_(s.head(cone.linear()).cwiseQuotient(z.head(cone.linear())).cwiseSqrt()),
      directions_(VectorX::Zero(cone.size())) {
  for (const Block& block : cone.blocks()) {
    const double of_s = std::sqrt(cone_determinant(s, block)), of_z = std::sqrt(cone_determinant(z, block));
    const auto s_bar = s.segment(block.first, block.size) / of_s, z_bar = z.segment(block.first, block.size) / of_z;
    const double twice = 2 * std::sqrt((1 + s_bar.dot(z_bar)) / 2);
    auto w = directions_.segment(block.first, block.size);
    w = s_bar - z_bar;
    w[0] += 2 * z_bar[0];
    w /= twice;
    lengths_.push_back(std::sqrt(of_s / of_z));
  }
}

VectorX NesterovToddScaling::apply(VectorX v, bool inverse) const {
  if (inverse)
    v.head(cone_.linear()).array() /= diagonal_.array();
  else
    v.head(cone_.linear()).array() *= diagonal_.array();
  for (std::size_t k = 0; k < lengths_.size(); ++k) {
    const Block& block = cone_.blocks()[k];
    const double w0 = directions_[block.first], sign = inverse ? -1 : 1;
    const auto w = tail(directions_, block);
    auto rest = v.segment(block.first + 1, block.size - 1);
    const double v0 = v[block.first], along = sign * w.dot(rest);
    const double factor = inverse ? 1 / lengths_[k] : lengths_[k];
    rest = factor * (rest + sign * (v0 + along / (1 + w0)) * w);
    v[block.first] = factor * (w0 * v0 + along);
  }
  return v;
}

MatrixX NesterovToddScaling::scale_rows_inverse(MatrixX matrix) const {
  matrix.topRows(cone_.linear()).array().colwise() /= diagonal_.array();
  for (std::size_t k = 0; k < lengths_.size(); ++k) {
    const Block& block = cone_.blocks()[k];
    const double w0 = directions_[block.first];
    const auto w = tail(directions_, block);
    auto rest = matrix.middleRows(block.first + 1, block.size - 1);
    const Eigen::RowVectorXd first = matrix.row(block.first), along = w.transpose() * rest;
    rest.noalias() += w * (along / (1 + w0) - first);
    matrix.row(block.first) = w0 * first - along;
    matrix.middleRows(block.first, block.size) /= lengths_[k];
  }
  return matrix;
}

}  // namespace balance::design
