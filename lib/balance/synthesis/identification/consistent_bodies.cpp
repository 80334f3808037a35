#include "balance/synthesis/identification/consistent_bodies.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::identification {

namespace {

constexpr int max_newton_steps = 100;
constexpr double decrement_tolerance = 1e-9;  ///< of half the squared Newton decrement
/// Least second moment of a prior body, in mass · (a tenth of the characteristic length)².
constexpr double min_prior_gyration = 0.1;
constexpr double min_prior_eigenvalue = 1e-3;  ///< of the prior's second moments, relative to their largest one
constexpr double loose_scale = 1e3;            ///< s of the last term, in magnitudes of the data's columns

/// P as a linear function of the inertial parameters: Σ_k p_k E_k.
std::vector<MatrixX> pseudo_inertia_basis(Eigen::Index count) {
  std::vector<MatrixX> basis(static_cast<std::size_t>(count), MatrixX::Zero(count == 4 ? 3 : 4, count == 4 ? 3 : 4));
  if (count == 4) {  // [J h; hᵀ m·1]
    basis[0](1, 1) = basis[0](2, 2) = 1;
    basis[1](0, 1) = basis[1](1, 0) = 1;
    basis[2](0, 2) = basis[2](2, 0) = 1;
    basis[3](0, 0) = 1;
    return basis;
  }
  basis[0](3, 3) = 1;
  for (std::size_t n = 0; n < 3; ++n) {
    const auto i = static_cast<Eigen::Index>(n);
    basis[1 + n](i, 3) = basis[1 + n](3, i) = 1;
    for (Eigen::Index k = 0; k < 3; ++k) basis[4 + n](k, k) = k == i ? -0.5 : 0.5;
  }
  basis[7](0, 1) = basis[7](1, 0) = basis[8](0, 2) = basis[8](2, 0) = basis[9](1, 2) = basis[9](2, 1) = -1;
  return basis;
}

MatrixX pseudo_inertia(const std::vector<MatrixX>& basis, const Eigen::Ref<const VectorX>& parameters) {
  MatrixX P = MatrixX::Zero(basis[0].rows(), basis[0].cols());
  for (std::size_t k = 0; k < basis.size(); ++k) P += parameters[static_cast<Eigen::Index>(k)] * basis[k];
  return P;
}

/// The parameters of a body with positive definite pseudo-inertia, equal to the given ones if theirs is.
VectorX make_consistent(VectorX p, double length, bool& repaired) {
  const double gyration = min_prior_gyration * length;
  if (p.size() == 4) {
    const double steiner = (p[1] * p[1] + p[2] * p[2]) / p[0];
    repaired = !(p[3] - steiner > min_prior_eigenvalue * p[0] * gyration * gyration);
    if (repaired) p[3] = steiner + p[0] * gyration * gyration;
    return p;
  }
  const std::vector<MatrixX> basis = pseudo_inertia_basis(10);
  const MatrixX P = pseudo_inertia(basis, p);
  const Vector3 h = P.block(0, 3, 3, 1);
  const Matrix3 central = P.topLeftCorner(3, 3) - h * h.transpose() / p[0];
  const numerics::SymmetricEigenSolver eigen{MatrixX(central)};
  const double largest =
      std::max(numerics::max_coefficient(eigen.eigenvalues()), min_prior_eigenvalue * p[0] * gyration * gyration);
  repaired = !(eigen.eigenvalues()[0] > min_prior_eigenvalue * largest) || !(eigen.eigenvalues()[2] >= largest);
  if (!repaired) return p;
  const VectorX raised = eigen.eigenvalues().cwiseMax(0.1 * largest).cwiseMax(p[0] * gyration * gyration / 10);
  const Matrix3 second =
      Matrix3(eigen.eigenvectors() * raised.asDiagonal() * eigen.eigenvectors().transpose()) + h * h.transpose() / p[0];
  const Matrix3 inertia = second.trace() * Matrix3::Identity() - second;
  p.tail(6) << inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2);
  return p;
}

struct PriorBody {
  Eigen::Index first;
  MatrixX inverse;  ///< P₀⁻¹
};

class ConsistentProblem {
 public:
  ConsistentProblem(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns, const MatrixX& A,
                    const VectorX& b, double weight)
      : weight_(weight),
        basis_(pseudo_inertia_basis(inertial_parameter_count(mechanism))),
        normal_(A.transpose() * A),
        right_(A.transpose() * b),
        constant_(0.5 * b.squaredNorm()) {
    const auto U = static_cast<Eigen::Index>(unknowns.size());
    start.resize(U);
    loose_.setZero(U);
    const VectorX norms = normal_.diagonal().cwiseSqrt();
    const double length = characteristic_length(mechanism);
    for (Eigen::Index k = 0; k < U; ++k) {
      const UnknownParameter& unknown = unknowns[static_cast<std::size_t>(k)];
      start[k] = unknown.spec_value;
      if (unknown.kind == UnknownKind::body || unknown.kind == UnknownKind::payload) continue;
      const double scale = loose_scale * std::max(std::abs(unknown.spec_value), norms[k] > 0 ? 1 / norms[k] : 1);
      loose_[k] = weight / (scale * scale);
    }
    for (Eigen::Index k = 0; k < U; ++k) {
      const UnknownParameter& unknown = unknowns[static_cast<std::size_t>(k)];
      if ((unknown.kind != UnknownKind::body && unknown.kind != UnknownKind::payload) || unknown.slot != 0) continue;
      VectorX p = start.segment(k, size());
      if (!(p[0] > 0)) p.setZero(), p[0] = unknown_payload_mass;
      bool repaired = false;
      start.segment(k, size()) = make_consistent(p, length, repaired);
      if (repaired) repaired_bodies.push_back(unknown.owner);
      bodies_.push_back({k, pseudo_inertia(basis_, start.segment(k, size())).inverse()});
    }
    spec_ = start;
  }

  /// Infinite outside of the consistent bodies.
  double value(const VectorX& x) const {
    double sum = 0.5 * x.dot(normal_ * x) - right_.dot(x) + constant_ + 0.5 * loose_.dot((x - spec_).cwiseAbs2());
    for (const PriorBody& body : bodies_) {
      const MatrixX P = pseudo_inertia(basis_, x.segment(body.first, size()));
      const Eigen::LLT<MatrixX> factor(P);
      if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
      double log_determinant = 0;
      for (Eigen::Index i = 0; i < P.rows(); ++i) log_determinant += 2 * elementary::log(factor.matrixLLT()(i, i));
      sum += weight_ * ((body.inverse * P).trace() - log_determinant);
    }
    return sum;
  }

  void derivatives(const VectorX& x, VectorX& gradient, MatrixX& hessian) const {
    gradient = normal_ * x - right_ + loose_.cwiseProduct(x - spec_);
    hessian = normal_;
    hessian.diagonal() += loose_;
    for (const PriorBody& body : bodies_) {
      const MatrixX inverse = pseudo_inertia(basis_, x.segment(body.first, size())).inverse();
      for (Eigen::Index k = 0; k < size(); ++k) {
        const MatrixX scaled = inverse * basis_[static_cast<std::size_t>(k)];
        gradient[body.first + k] +=
            weight_ * ((body.inverse * basis_[static_cast<std::size_t>(k)]).trace() - scaled.trace());
        for (Eigen::Index l = 0; l < size(); ++l)
          hessian(body.first + k, body.first + l) +=
              weight_ * (scaled * inverse * basis_[static_cast<std::size_t>(l)]).trace();
      }
    }
  }

  VectorX start;
  std::vector<std::string> repaired_bodies;

 private:
  /// [kg] of a payload of which the spec says nothing.
  static constexpr double unknown_payload_mass = 1;

  Eigen::Index size() const { return static_cast<Eigen::Index>(basis_.size()); }

  double weight_;
  std::vector<MatrixX> basis_;
  MatrixX normal_;
  VectorX right_;
  double constant_;
  VectorX loose_, spec_;
  std::vector<PriorBody> bodies_;
};

}  // namespace

ConsistentFit fit_consistent_bodies(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns,
                                    const MatrixX& A, const VectorX& b, double weight) {
  ConsistentProblem problem(mechanism, unknowns, A, b, weight);
  ConsistentFit fit{.x = problem.start, .covariance = {}, .repaired = problem.repaired_bodies};
  VectorX gradient;
  MatrixX hessian;
  for (int step_count = 0; step_count < max_newton_steps; ++step_count) {
    problem.derivatives(fit.x, gradient, hessian);
    const VectorX scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixX scaled = scale.asDiagonal() * hessian * scale.asDiagonal();
    const Eigen::LLT<MatrixX> factor(scaled);
    const VectorX step = -scale.cwiseProduct(factor.solve(VectorX(scale.cwiseProduct(gradient))));
    fit.covariance =
        scale.asDiagonal() * factor.solve(MatrixX::Identity(scale.size(), scale.size())) * scale.asDiagonal();
    const double decrement = -0.5 * gradient.dot(step);
    if (!(decrement > decrement_tolerance)) {
      fit.is_converged = decrement >= -decrement_tolerance;
      break;
    }
    const double value = problem.value(fit.x);
    double length = 1;
    while (length > 1e-12 && !(problem.value(fit.x + length * step) <= value - 0.1 * length * decrement)) length /= 2;
    if (!(length > 1e-12)) {
      fit.is_converged = decrement <= 1e-6 * (1 + std::abs(value));  // round-off of the value hides the rest
      break;
    }
    fit.x += length * step;
  }
  return fit;
}

double consistency_margin(const VectorX& p) {
  if (!(p[0] > 0)) return -1;
  const MatrixX P = pseudo_inertia(pseudo_inertia_basis(p.size()), p);
  VectorX scale(P.rows());
  for (Eigen::Index i = 0; i < P.rows(); ++i) scale[i] = P(i, i) > 0 ? 1 / std::sqrt(P(i, i)) : 0;
  const numerics::SymmetricEigenSolver eigen(MatrixX(scale.asDiagonal() * P * scale.asDiagonal()),
                                             Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0];
}

}  // namespace balance::identification
