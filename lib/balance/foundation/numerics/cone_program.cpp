#include "balance/foundation/numerics/cone_program.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::numerics {

namespace {

constexpr int max_interior_point_iterations = 60;
/// Relative error below which a point counts as a solution although round-off prevents a smaller one.
constexpr double acceptable_error_tolerance = 1e-7;

class InteriorPointMethod {
 public:
  InteriorPointMethod(const ConeProgram& program, double tolerance)
      : program_(program),
        cone_(program.linear_rows, program.cone_sizes),
        identity_(cone_.identity()),
        tolerance_(tolerance) {}

  ConeSolution run() {
    initialise();
    for (best_.iterations = 0; best_.iterations < max_interior_point_iterations; ++best_.iterations) {
      update_residuals();
      if (error_ < tolerance_ || !std::isfinite(error_) ||
          (best_error_ < acceptable_error_tolerance && error_ > 1e4 * best_error_))
        break;
      if (!take_step()) break;
    }
    best_.status = best_error_ < acceptable_error_tolerance ? ConeStatus::optimal : ConeStatus::failed;
    if (best_.x.size() == 0) best_.x = VectorX::Zero(program_.cost.size());
    best_.primal_value = program_.cost.dot(best_.x);
    best_.dual_value = best_.multipliers.size() > 0 ? -program_.rhs.dot(best_.multipliers) : -INFINITY;
    return best_;
  }

 private:
  /// Least-squares points, shifted into the cone.
  void initialise() {
    const Eigen::HouseholderQR<MatrixX> qr(program_.matrix);
    const auto n = program_.cost.size();
    x_ = qr.solve(program_.rhs);
    s_ = program_.rhs - program_.matrix * x_;
    const double rows = std::max(max_abs(program_.matrix.rowwise().norm()), 1e-300);
    if (const double m = cone_.min_eigenvalue(s_); m < 1e-3 * rows) s_ += (0.1 * rows - m) * identity_;
    VectorX y = VectorX::Zero(program_.rhs.size());
    y.head(n) = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>().transpose().solve(-program_.cost);
    z_ = qr.householderQ() * y;
    if (const double m = cone_.min_eigenvalue(z_); m < 1e-3)
      z_ += (0.1 + program_.cost.lpNorm<Eigen::Infinity>() - m) * identity_;
  }

  void update_residuals() {
    dual_residual_ = program_.cost + program_.matrix.transpose() * z_;
    primal_residual_ = program_.matrix * x_ + s_ - program_.rhs;
    gap_ = s_.dot(z_);
    error_ =
        std::max({dual_residual_.norm() / (1 + program_.cost.norm()),
                  primal_residual_.norm() / (1 + program_.rhs.norm()), gap_ / (1 + std::abs(program_.cost.dot(x_)))});
    if (!(error_ < best_error_)) return;
    best_error_ = error_;
    best_.x = x_;
    best_.slack = s_;
    best_.multipliers = z_;
  }

  struct Direction {
    VectorX x, s, z, scaled_s, scaled_z;
  };

  /// One predictor and one corrector step. @return false if round-off prevents further progress
  bool take_step() {
    const NesterovToddScaling scaling(cone_, s_, z_);
    const VectorX lambda = scaling.apply(z_);
    const MatrixX scaled = scaling.scale_rows_inverse(program_.matrix);
    if (!lambda.allFinite() || !scaled.allFinite()) return false;
    const Eigen::HouseholderQR<MatrixX> qr(scaled);
    const auto direction = [&](const VectorX& target, double factor) {
      return solve(scaling, lambda, scaled, qr, target, factor);
    };
    const VectorX complementary = -cone_.jordan_product(lambda, lambda);
    const Direction affine = direction(complementary, 1);
    if (!affine.x.allFinite() || !affine.s.allFinite() || !affine.z.allFinite()) return false;
    const double affine_step = std::min({1.0, cone_.max_step(s_, affine.s), cone_.max_step(z_, affine.z)});
    const double centring = elementary::pow(1 - affine_step, 3);
    const Direction d = direction(complementary - cone_.jordan_product(affine.scaled_s, affine.scaled_z) +
                                      centring * gap_ / static_cast<double>(cone_.degree()) * identity_,
                                  1 - centring);
    if (!d.x.allFinite() || !d.s.allFinite() || !d.z.allFinite()) return false;
    const double step = std::min(1.0, 0.99 * std::min(cone_.max_step(s_, d.s), cone_.max_step(z_, d.z)));
    if (!(step > 1e-9)) return false;
    x_ += step * d.x;
    s_ += step * d.s;
    z_ += step * d.z;
    return true;
  }

  /// Solves λ ∘ (W dz + W⁻¹ ds) = target with both residuals reduced by `factor`.
  Direction solve(const NesterovToddScaling& scaling, const VectorX& lambda, const MatrixX& scaled,
                  const Eigen::HouseholderQR<MatrixX>& qr, const VectorX& target, double factor) const {
    const auto n = program_.cost.size();
    const VectorX t = cone_.jordan_quotient(lambda, target);
    const VectorX b = scaling.apply_inverse(-factor * primal_residual_) - t;
    const auto r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
    const VectorX projected = qr.householderQ().adjoint() * b;
    const VectorX y = projected.head(n) + VectorX(r.transpose().solve(-factor * dual_residual_));
    Direction d;
    d.x = r.solve(y);
    d.scaled_z = scaled * d.x - b;
    d.scaled_s = t - d.scaled_z;
    d.s = scaling.apply(d.scaled_s);
    d.z = scaling.apply_inverse(d.scaled_z);
    return d;
  }

  const ConeProgram& program_;
  SecondOrderCone cone_;
  VectorX identity_;
  double tolerance_;
  VectorX x_, s_, z_, dual_residual_, primal_residual_;
  double gap_ = 0, error_ = INFINITY, best_error_ = INFINITY;
  ConeSolution best_;
};

void copy_rows(const std::vector<std::pair<MatrixX, VectorX>>& row_groups, double sign, Eigen::Index& row,
               ConeProgram& program) {
  for (const auto& [rows, rhs] : row_groups) {
    program.matrix.middleRows(row, rows.rows()) = sign * rows;
    program.rhs.segment(row, rows.rows()) = rhs;
    row += rows.rows();
  }
}

}  // namespace

void ConeProgramBuilder::add_inequalities(const Eigen::Ref<const VectorX>& coefficients, double limit) {
  linear_.emplace_back(coefficients.transpose(), VectorX::Constant(1, limit));
  ++count_linear_;
}

void ConeProgramBuilder::add_inequalities(const Eigen::Ref<const MatrixX>& rows,
                                          const Eigen::Ref<const VectorX>& limits) {
  linear_.emplace_back(rows, limits);
  count_linear_ += rows.rows();
}

void ConeProgramBuilder::add_cone(const Eigen::Ref<const MatrixX>& rows, const Eigen::Ref<const VectorX>& constant) {
  cones_.emplace_back(rows, constant);
  count_conic_ += rows.rows();
}

ConeProgram ConeProgramBuilder::build(VectorX cost) const {
  ConeProgram program;
  program.cost = std::move(cost);
  program.linear_rows = count_linear_;
  for (const auto& cone : cones_) program.cone_sizes.push_back(cone.first.rows());
  program.matrix.resize(count_linear_ + count_conic_, variables_);
  program.rhs.resize(count_linear_ + count_conic_);
  Eigen::Index row = 0;
  copy_rows(linear_, 1, row, program);
  copy_rows(cones_, -1, row, program);
  return program;
}

ConeProgram add_inequalities(const ConeProgram& program, const MatrixX& matrix, const VectorX& rhs) {
  ConeProgram extended = program;
  const Eigen::Index linear = program.linear_rows, added = matrix.rows(), conic = program.rhs.size() - linear;
  extended.linear_rows += added;
  extended.matrix.resize(linear + added + conic, program.matrix.cols());
  extended.matrix << program.matrix.topRows(linear), matrix, program.matrix.bottomRows(conic);
  extended.rhs.resize(extended.matrix.rows());
  extended.rhs << program.rhs.head(linear), rhs, program.rhs.tail(conic);
  return extended;
}

ConeSolution solve_cone_program(const ConeProgram& program, double tolerance) {
  return InteriorPointMethod(program, tolerance).run();
}

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using Block = SecondOrderCone::Block;

auto tail(const VectorX& x, const Block& block) { return x.segment(block.first + 1, block.size - 1); }

/// The smallest positive step at which t² − |v|² of x + step · d vanishes.
double block_step(const VectorX& x, const VectorX& d, const Block& block) {
  const double a = cone_determinant(d, block), c = cone_determinant(x, block);
  const double b = x[block.first] * d[block.first] - tail(x, block).dot(tail(d, block));
  const double discriminant = b * b - a * c;
  if (!(a < 0 || (b < 0 && discriminant >= 0))) return infinity;
  const double denominator = -b + std::sqrt(std::max(discriminant, 0.0));
  return denominator > 0 ? c / denominator : infinity;
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
    const auto vector_size = block.size - 1;
    result.segment(block.first + 1, vector_size) = a[block.first] * tail(b, block) + b[block.first] * tail(a, block);
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
  double min_value = min_coefficient(x.head(linear_));
  for (const Block& block : blocks_) min_value = std::min(min_value, x[block.first] - tail(x, block).norm());
  return min_value;
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
    const double s_root = std::sqrt(cone_determinant(s, block)), z_root = std::sqrt(cone_determinant(z, block));
    const auto s_bar = s.segment(block.first, block.size) / s_root, z_bar = z.segment(block.first, block.size) / z_root;
    const double two_gamma = 2 * std::sqrt((1 + s_bar.dot(z_bar)) / 2);
    auto w = directions_.segment(block.first, block.size);
    w = s_bar - z_bar;
    w[0] += 2 * z_bar[0];
    w /= two_gamma;
    lengths_.push_back(std::sqrt(s_root / z_root));
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
    auto vector_part = v.segment(block.first + 1, block.size - 1);
    const double v0 = v[block.first], projection = sign * w.dot(vector_part);
    const double factor = inverse ? 1 / lengths_[k] : lengths_[k];
    vector_part = factor * (vector_part + sign * (v0 + projection / (1 + w0)) * w);
    v[block.first] = factor * (w0 * v0 + projection);
  }
  return v;
}

MatrixX NesterovToddScaling::scale_rows_inverse(MatrixX matrix) const {
  matrix.topRows(cone_.linear()).array().colwise() /= diagonal_.array();
  for (std::size_t k = 0; k < lengths_.size(); ++k) {
    const Block& block = cone_.blocks()[k];
    const double w0 = directions_[block.first];
    const auto w = tail(directions_, block);
    auto vector_part = matrix.middleRows(block.first + 1, block.size - 1);
    const Eigen::RowVectorXd first = matrix.row(block.first), projection = w.transpose() * vector_part;
    vector_part.noalias() += w * (projection / (1 + w0) - first);
    matrix.row(block.first) = w0 * first - projection;
    matrix.middleRows(block.first, block.size) /= lengths_[k];
  }
  return matrix;
}

}  // namespace balance::numerics
