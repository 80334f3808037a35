#include "balance/design/cone_program.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

constexpr int max_interior_point_iterations = 60;
/// Relative error below which a point counts as a solution although the last digits were out of reach.
constexpr double acceptable_error_tolerance = 1e-7;

class InteriorPointMethod {
 public:
  InteriorPointMethod(const ConeProgram& program, double tolerance)
      : program_(program),
        cone_(program.linear_rows, program.cone_sizes),
        unit_(cone_.identity()),
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
  /// Least-squares points, moved into the cone.
  void initialise() {
    const Eigen::HouseholderQR<MatrixX> qr(program_.matrix);
    const auto n = program_.cost.size();
    x_ = qr.solve(program_.rhs);
    s_ = program_.rhs - program_.matrix * x_;
    const double rows = std::max(max_abs(program_.matrix.rowwise().norm()), 1e-300);
    if (const double m = cone_.min_eigenvalue(s_); m < 1e-3 * rows) s_ += (0.1 * rows - m) * unit_;
    VectorX y = VectorX::Zero(program_.rhs.size());
    y.head(n) = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>().transpose().solve(-program_.cost);
    z_ = qr.householderQ() * y;
    if (const double m = cone_.min_eigenvalue(z_); m < 1e-3)
      z_ += (0.1 + program_.cost.lpNorm<Eigen::Infinity>() - m) * unit_;
  }

  void update_residuals() {
    dual_ = program_.cost + program_.matrix.transpose() * z_;
    primal_ = program_.matrix * x_ + s_ - program_.rhs;
    gap_ = s_.dot(z_);
    error_ = std::max({dual_.norm() / (1 + program_.cost.norm()), primal_.norm() / (1 + program_.rhs.norm()),
                       gap_ / (1 + std::abs(program_.cost.dot(x_)))});
    if (!(error_ < best_error_)) return;
    best_error_ = error_;
    best_.x = x_;
    best_.slack = s_;
    best_.multipliers = z_;
  }

  struct Direction {
    VectorX x, s, z, scaled_s, scaled_z;
  };

  /// One predictor and one corrector step. @return false at the end of the digits
  bool take_step() {
    const NesterovToddScaling scaling(cone_, s_, z_);
    const VectorX lambda = scaling.apply(z_);
    const MatrixX scaled = scaling.scale_rows_inverse(program_.matrix);
    if (!lambda.allFinite() || !scaled.allFinite()) return false;
    const Eigen::HouseholderQR<MatrixX> qr(scaled);
    const auto direction = [&](const VectorX& aim, double factor) {
      return solve(scaling, lambda, scaled, qr, aim, factor);
    };
    const VectorX complementary = -cone_.jordan_product(lambda, lambda);
    const Direction affine = direction(complementary, 1);
    if (!affine.x.allFinite() || !affine.s.allFinite() || !affine.z.allFinite()) return false;
    const double reach = std::min({1.0, cone_.max_step(s_, affine.s), cone_.max_step(z_, affine.z)});
    const double centring = elementary::pow(1 - reach, 3);
    const Direction d = direction(complementary - cone_.jordan_product(affine.scaled_s, affine.scaled_z) +
                                      centring * gap_ / static_cast<double>(cone_.degree()) * unit_,
                                  1 - centring);
    if (!d.x.allFinite() || !d.s.allFinite() || !d.z.allFinite()) return false;
    const double step = std::min(1.0, 0.99 * std::min(cone_.max_step(s_, d.s), cone_.max_step(z_, d.z)));
    if (!(step > 1e-9)) return false;
    x_ += step * d.x;
    s_ += step * d.s;
    z_ += step * d.z;
    return true;
  }

  /// λ ∘ (W dz + W⁻¹ ds) = aim with both residuals reduced by `factor`.
  Direction solve(const NesterovToddScaling& scaling, const VectorX& lambda, const MatrixX& scaled,
                  const Eigen::HouseholderQR<MatrixX>& qr, const VectorX& aim, double factor) const {
    const auto n = program_.cost.size();
    const VectorX t = cone_.jordan_quotient(lambda, aim);
    const VectorX b = scaling.apply_inverse(-factor * primal_) - t;
    const auto r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
    const VectorX projected = qr.householderQ().adjoint() * b;
    const VectorX y = projected.head(n) + VectorX(r.transpose().solve(-factor * dual_));
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
  VectorX unit_;
  double tolerance_;
  VectorX x_, s_, z_, dual_, primal_;
  double gap_ = 0, error_ = INFINITY, best_error_ = INFINITY;
  ConeSolution best_;
};

void copy_rows(const std::vector<std::pair<MatrixX, VectorX>>& parts, double sign, Eigen::Index& row,
               ConeProgram& program) {
  for (const auto& [rows, right] : parts) {
    program.matrix.middleRows(row, rows.rows()) = sign * rows;
    program.rhs.segment(row, rows.rows()) = right;
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
  for (const auto& part : cones_) program.cone_sizes.push_back(part.first.rows());
  program.matrix.resize(count_linear_ + count_conic_, variables_);
  program.rhs.resize(count_linear_ + count_conic_);
  Eigen::Index row = 0;
  copy_rows(linear_, 1, row, program);
  copy_rows(cones_, -1, row, program);
  return program;
}

ConeProgram add_inequalities(const ConeProgram& program, const MatrixX& matrix, const VectorX& right) {
  ConeProgram more = program;
  const Eigen::Index linear = program.linear_rows, added = matrix.rows(), conic = program.rhs.size() - linear;
  more.linear_rows += added;
  more.matrix.resize(linear + added + conic, program.matrix.cols());
  more.matrix << program.matrix.topRows(linear), matrix, program.matrix.bottomRows(conic);
  more.rhs.resize(more.matrix.rows());
  more.rhs << program.rhs.head(linear), right, program.rhs.tail(conic);
  return more;
}

ConeSolution solve_cone_program(const ConeProgram& program, double tolerance) {
  return InteriorPointMethod(program, tolerance).run();
}

}  // namespace balance::design
