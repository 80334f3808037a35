#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/conditions/farkas.hpp"
#include "balance/conditions/linear_program.hpp"

#include <cmath>
#include <map>
#include <utility>

namespace balance {

namespace {

/// A linear program's solution this small beside one stands for zero; what is kept is computed anew without it.
constexpr double program_zero_tolerance = 1e-7;

/// Up to so many, combinations around every single one are tried.
constexpr std::size_t max_single_body_searches = 20;

using Indices = std::vector<Eigen::Index>;

class SignCertificateSearch {
 public:
  SignCertificateSearch(const MatrixX& rows, const std::vector<Parameter>& parameters)
      : rows_(rows), n_(rows.rows()), signs_(2 * rows.rows()), signed_(VectorX::Zero(rows.cols())) {
    signs_.lower.setZero();
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const auto p = static_cast<Eigen::Index>(i);
      const ParameterSign sign = parameter_sign(parameters[i]);
      signs_.add_row(0, split(rows_.col(p)), sign == ParameterSign::indefinite ? 0 : no_bound);
      if (sign != ParameterSign::indefinite) signed_[p] = 1;
      if (sign == ParameterSign::positive) bodies_[parameters[i].index].push_back(p);
    }
  }

  std::optional<FarkasCertificate> find_sparsest() {
    Indices all;
    for (const auto& [body, parameters] : bodies_) all.insert(all.end(), parameters.begin(), parameters.end());
    if (!reduce_terms(all)) return std::nullopt;
    if (bodies_.size() <= max_single_body_searches)
      for (const auto& [body, parameters] : bodies_) reduce_terms(parameters);
    return best_;
  }

 private:
  /// Combinations in which the coefficients of some bodies' masses and moments of inertia add up to one. Weights that grow where
  /// a term is small drive small terms to zero (Candès, Wakin, Boyd, 2008).
  /// @return false if there are none
  bool reduce_terms(const Indices& some) {
    LinearProgram program = signs_;
    program.add_row(1, split(rows_(Eigen::all, some).rowwise().sum()), 1);
    VectorX weight = VectorX::Zero(rows_.cols());
    for (int round = 0; round < 4; ++round) {
      program.cost = split(rows_ * weight) + VectorX::Constant(2 * n_, round == 0 ? 1 : 0.01);
      const LinearProgramSolution solution = solve_linear_program(program);
      if (solution.status != LinearProgramStatus::optimal) return round > 0;
      const VectorX lambda = solution.x.head(n_) - solution.x.tail(n_);
      const std::optional<FarkasCertificate> found = refine(lambda);
      if (found && (!best_ || length(*found) < length(*best_))) best_ = found;
      const VectorX coefficients = rows_.transpose() * lambda;
      weight = signed_.array() / (coefficients.array().abs() + 1e-3);
    }
    return true;
  }

  /// λ = λ⁺ − λ⁻.
  static VectorX split(const VectorX& row) {
    VectorX both(2 * row.size());
    both << row, -row;
    return both;
  }

  static std::pair<Eigen::Index, Eigen::Index> length(const FarkasCertificate& found) {
    return {(found.coefficients.array() != 0).count(), (found.combination.array() != 0).count()};
  }

  /// The same combination to full accuracy: the conditions that take part are combined anew such that what the program has made
  /// zero is zero.
  std::optional<FarkasCertificate> refine(const VectorX& lambda) const {
    const VectorX rough = rows_.transpose() * lambda;
    const double size = max_abs(lambda);
    Indices part, gone, kept;
    for (Eigen::Index r = 0; r < n_; ++r)
      if (std::abs(lambda[r]) > program_zero_tolerance * size) part.push_back(r);
    for (Eigen::Index p = 0; p < rows_.cols(); ++p)
      (signed_[p] > 0 && rough[p] > program_zero_tolerance ? kept : gone).push_back(p);
    const SingularValueDecomposition svd(rows_(part, gone), Eigen::ComputeFullU);
    VectorX exact = lambda(part);
    for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
      if (svd.singularValues()[i] > certificate_coefficient_tolerance)
        exact -= svd.matrixU().col(i) * svd.matrixU().col(i).dot(exact);
    return verified(part, kept, exact);
  }

  std::optional<FarkasCertificate> verified(const Indices& part, const Indices& kept, const VectorX& lambda) const {
    FarkasCertificate out{VectorX::Zero(n_), VectorX::Zero(rows_.cols())};
    out.combination(part) = lambda;
    VectorX left = rows_.transpose() * out.combination;
    for (const Eigen::Index p : kept) {
      if (!(left[p] > 0)) return std::nullopt;
      std::swap(out.coefficients[p], left[p]);
    }
    const double size = max_coefficient(out.coefficients);
    double bodies = 0;
    for (const auto& [body, parameters] : bodies_) bodies += out.coefficients(parameters).sum();
    if (!(bodies > 1e-3 * size) || max_abs(left) > certificate_coefficient_tolerance * size) return std::nullopt;
    return out;
  }

  MatrixX rows_;
  Eigen::Index n_;
  LinearProgram signs_;            ///< of λ⁺, λ⁻: every coefficient's sign
  VectorX signed_;                 ///< 1 where the parameter cannot be negative
  std::map<int, Indices> bodies_;  ///< their masses and moments of inertia
  std::optional<FarkasCertificate> best_;
};

}  // namespace

std::optional<FarkasCertificate> find_sign_certificate(const MatrixX& rows, const std::vector<Parameter>& parameters) {
  return SignCertificateSearch(rows, parameters).find_sparsest();
}

}  // namespace balance
