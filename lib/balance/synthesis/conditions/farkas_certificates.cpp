// Semidefinite feasibility by cutting planes: a linear program represents each matrix Q by vᵀQv ≥ 0 for a few vectors
// v, and the eigenvectors of negative eigenvalues at its solution are added to them. If the program becomes infeasible,
// there is no certificate. The final point is moved into the interior of the cone if possible, and otherwise (Q must be
// singular) exactly onto its boundary.

#include "balance/synthesis/conditions/farkas_certificates.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

namespace balance::conditions {

using dynamics::Parameter;
using dynamics::ParameterKind;
using numerics::LinearProgram;

std::optional<VectorX> find_bounds_certificate(const VectorX& constant, const MatrixX& gradient, const VectorX& lower,
                                               const VectorX& upper) {
  const Eigen::Index n = gradient.rows(), z = gradient.cols();
  // Unknowns: λ⁺, λ⁻ and the gradient of the left-hand side split into its positive and negative parts, gᵀ = λᵀ
  // gradient = rise − fall. Where it rises with z, its minimum is at the lower bound.
  LinearProgram program(2 * n + 2 * z);
  program.lower.setZero();
  program.cost.head(2 * n).setOnes();
  VectorX minimum_row(2 * n + 2 * z);
  minimum_row << constant, -constant, lower, -upper;
  for (Eigen::Index j = 0; j < z; ++j) {
    VectorX gradient_row = VectorX::Zero(2 * n + 2 * z);
    gradient_row.head(n) = gradient.col(j);
    gradient_row.segment(n, n) = -gradient.col(j);
    gradient_row[2 * n + j] = -1;
    gradient_row[2 * n + z + j] = 1;
    program.add_row(0, gradient_row, 0);
    if (lower[j] == -numerics::no_bound) program.upper[2 * n + j] = minimum_row[2 * n + j] = 0;
    if (upper[j] == numerics::no_bound) program.upper[2 * n + z + j] = minimum_row[2 * n + z + j] = 0;
  }
  program.add_row(1, minimum_row, numerics::no_bound);
  const numerics::LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status != numerics::LinearProgramStatus::optimal) return std::nullopt;
  return solution.x.head(n) - solution.x.segment(n, n);
}

namespace {

/// Tolerated negative eigenvalue, relative to the largest coefficient; conditions are not more accurate.
constexpr double eigenvalue_tolerance = 1e-10;
/// Margin sought inside the cone, relative to a matrix' norm.
constexpr double interior_margin = 1e-3;
/// A matrix with a norm below this counts as zero.
constexpr double zero_matrix_tolerance = 1e-8;
constexpr double max_multiplier = 1e4;
constexpr int max_cutting_plane_rounds = 80;

using Eigen::Index;

class ConeCertificateSearch {
 public:
  ConeCertificateSearch(const MatrixX& rows, const PseudoInertiaCone& cone)
      : rows_(rows), cone_(cone), n_(rows.rows()), trace_(n_) {
    trace_.setZero();
    for (const PseudoInertiaBlock& block : cone_.blocks)
      for (Index i = 0; block.is_body && i < block.size; ++i) {
        const VectorX v = VectorX::Unit(block.size, i);
        trace_ += form(block, v, v);
      }
    for (std::size_t b = 0; b < cone_.blocks.size(); ++b) add_first_cuts(b);
  }

  std::optional<FarkasCertificate> find() {
    const std::optional<VectorX> start = search(first_program());
    if (!start) return std::nullopt;
    const std::optional<VectorX> interior = search(inner_program(*start));
    for (const VectorX& candidate : {interior.value_or(*start), *start}) {
      if (std::optional<FarkasCertificate> certificate = verify(refine_at_tangency(candidate))) return certificate;
      for (const double null_tolerance : {1e-5, 1e-3, 1e-7, 0.0})
        if (std::optional<FarkasCertificate> certificate = verify(refine_by_newton(candidate, null_tolerance)))
          return certificate;
    }
    return std::nullopt;
  }

 private:
  struct Cut {
    std::size_t block;
    VectorX row;  ///< in λ: vᵀ Q v
  };

  /// The row whose product with λ is uᵀ Q v.
  VectorX form(const PseudoInertiaBlock& block, const VectorX& u, const VectorX& v) const {
    return rows_ * block.bilinear_form_row(u, v, rows_.cols());
  }

  void add_first_cuts(std::size_t b) {
    const PseudoInertiaBlock& block = cone_.blocks[b];
    for (Index i = 0; i < block.size; ++i) {
      add_cut(b, VectorX::Unit(block.size, i));
      for (Index j = 0; j < i; ++j)
        for (const double s : {-1.0, 1.0}) add_cut(b, VectorX::Unit(block.size, i) + s * VectorX::Unit(block.size, j));
    }
  }

  void add_cut(std::size_t b, const VectorX& v) {
    const VectorX row = form(cone_.blocks[b], v, v);
    if (numerics::max_abs(row) > 0) cuts_.push_back({b, row});
  }

  /// Unknowns: λ⁺, λ⁻ and, per block, the margin t with Q ⪰ t I.
  VectorX program_row(const VectorX& lambda, const Cut* cut = nullptr) const {
    VectorX row = VectorX::Zero(2 * n_ + blocks());
    row.head(n_) = lambda;
    row.segment(n_, n_) = -lambda;
    if (cut) row[2 * n_ + static_cast<Index>(cut->block)] = -1;
    return row;
  }

  Index blocks() const { return static_cast<Index>(cone_.blocks.size()); }

  LinearProgram common_program() const {
    LinearProgram program(2 * n_ + blocks());
    program.lower.setZero();
    program.upper.head(2 * n_).setConstant(max_multiplier);
    program.upper.tail(blocks()).setZero();
    program.cost.head(2 * n_).setOnes();
    program.add_row(1, program_row(trace_), 1);
    for (const Index p : cone_.excluded) program.add_row(0, program_row(rows_.col(p)), 0);
    return program;
  }

  /// Few conditions, no margin.
  LinearProgram first_program() const { return common_program(); }

  /// The same conditions and the same bodies, with the maximum margin.
  LinearProgram inner_program(const VectorX& start) const {
    LinearProgram program = common_program();
    program.cost.head(2 * n_).setConstant(1e-6);
    program.cost.tail(blocks()).setConstant(-1);
    for (Index r = 0; r < n_; ++r)
      if (start[r] == 0) program.upper[r] = program.upper[n_ + r] = 0;
    const VectorX coefficients = rows_.transpose() * start;
    for (Index b = 0; b < blocks(); ++b) {
      const PseudoInertiaBlock& block = cone_.blocks[static_cast<std::size_t>(b)];
      const double size = block.matrix(coefficients).norm();
      if (size > certificate_coefficient_tolerance) {
        program.upper[2 * n_ + b] = interior_margin * size;
      } else {
        for (const PseudoInertiaBlock::Term& term : block.terms)
          program.add_row(0, program_row(rows_.col(term.parameter)), 0);
      }
    }
    return program;
  }

  /// Alternates between solving and cutting until no matrix is indefinite.
  std::optional<VectorX> search(LinearProgram program) {
    std::size_t added = 0;
    for (int round = 0; round < max_cutting_plane_rounds; ++round) {
      for (; added < cuts_.size(); ++added)
        program.add_row(0, program_row(cuts_[added].row, &cuts_[added]), numerics::no_bound);
      const numerics::LinearProgramSolution solution = solve_linear_program(program);
      if (solution.status != numerics::LinearProgramStatus::optimal) return std::nullopt;
      VectorX lambda = solution.x.head(n_) - solution.x.segment(n_, n_);
      for (double& factor : lambda)
        if (std::abs(factor) < certificate_coefficient_tolerance) factor = 0;
      if (!add_eigenvector_cuts(lambda, solution.x.tail(blocks()))) return lambda;
    }
    return std::nullopt;
  }

  /// @return false if there was nothing to cut
  bool add_eigenvector_cuts(const VectorX& lambda, const VectorX& margins) {
    const VectorX coefficients = rows_.transpose() * lambda;
    const std::size_t previous_count = cuts_.size();
    for (std::size_t b = 0; b < cone_.blocks.size(); ++b) {
      const numerics::SymmetricEigenSolver solver(cone_.blocks[b].matrix(coefficients));
      for (Index i = 0; i < solver.eigenvalues().size(); ++i)
        if (solver.eigenvalues()[i] < margins[static_cast<Index>(b)] - 10 * certificate_coefficient_tolerance)
          add_cut(b, solver.eigenvectors().col(i));
    }
    return cuts_.size() > previous_count;
  }

  /// Newton's method on these equations: excluded coefficients are zero, the trace is one, matrices of norm zero
  /// vanish, and eigenvalues below `null_tolerance` (relative to their matrix) are zero.
  VectorX refine_by_newton(VectorX lambda, double null_tolerance) const {
    const std::vector<Index> active = active_conditions(lambda);
    for (int round = 0; round < 8; ++round) {
      const VectorX coefficients = rows_.transpose() * lambda;
      std::vector<VectorX> rows = equations(coefficients);
      for (const PseudoInertiaBlock& block : cone_.blocks) {
        const Spectrum spectrum(block, coefficients, null_tolerance);
        for (Index i = 0; i < spectrum.null; ++i)
          for (Index k = 0; k <= i; ++k) rows.push_back(form(block, spectrum.vectors.col(i), spectrum.vectors.col(k)));
      }
      const MatrixX jacobian = stack_rows(rows);
      VectorX residual = -jacobian * lambda;
      residual[0] += 1;
      lambda(active) += least_squares(jacobian(Eigen::all, active), residual);
    }
    return lambda;
  }

  /// Where the family of matrices only touches the cone, its smallest eigenvalues have their maximum, zero, and
  /// Newton's method on their values fails. This one works on the gradient of their sum, with all other equations kept.
  VectorX refine_at_tangency(VectorX lambda) const {
    const std::vector<Index> active = active_conditions(lambda);
    for (int round = 0; round < 3; ++round) {
      const VectorX coefficients = rows_.transpose() * lambda;
      VectorX gradient = VectorX::Zero(n_);
      MatrixX hessian = MatrixX::Zero(n_, n_);
      for (const PseudoInertiaBlock& block : cone_.blocks) {
        const Spectrum s(block, coefficients, 1e-5);
        for (Index a = 0; a < s.null; ++a) {
          gradient += form(block, s.vectors.col(a), s.vectors.col(a));
          for (Index b = s.null; b < block.size; ++b) {
            const VectorX coupling_row = form(block, s.vectors.col(a), s.vectors.col(b));
            hessian -= 2 / (s.values[b] - s.values[a]) * coupling_row * coupling_row.transpose();
          }
        }
      }
      const Eigen::FullPivLU<MatrixX> equation_lu(stack_rows(equations(coefficients))(Eigen::all, active));
      const MatrixX tangent_basis = equation_lu.kernel();
      if (tangent_basis.isZero(0)) break;
      const MatrixX curvature = tangent_basis.transpose() * hessian(active, active) * tangent_basis;
      lambda(active) -= tangent_basis * least_squares(curvature, tangent_basis.transpose() * gradient(active));
    }
    return lambda;
  }

  /// Eigenvalues in increasing order, and the number of those that are zero.
  struct Spectrum {
    VectorX values;
    MatrixX vectors;
    Index null = 0;

    Spectrum(const PseudoInertiaBlock& block, const VectorX& coefficients, double null_tolerance) {
      const MatrixX matrix = block.matrix(coefficients);
      const double size = matrix.norm();
      const numerics::SymmetricEigenSolver solver(matrix);
      values = solver.eigenvalues(), vectors = solver.eigenvectors();
      if (size >= zero_matrix_tolerance) null = (values.array() < null_tolerance * size).count();
      if (null_tolerance == 0) null = 0;
    }
  };

  static std::vector<Index> active_conditions(const VectorX& lambda) {
    std::vector<Index> active;
    for (Index r = 0; r < lambda.size(); ++r)
      if (lambda[r] != 0) active.push_back(r);
    return active;
  }

  /// Rows in λ that give the trace, the excluded coefficients and the entries of matrices that vanish.
  std::vector<VectorX> equations(const VectorX& coefficients) const {
    std::vector<VectorX> rows = {trace_};
    for (const Index p : cone_.excluded) rows.emplace_back(rows_.col(p));
    for (const PseudoInertiaBlock& block : cone_.blocks)
      if (block.matrix(coefficients).norm() < zero_matrix_tolerance)
        for (const PseudoInertiaBlock::Term& term : block.terms) rows.emplace_back(rows_.col(term.parameter));
    return rows;
  }

  MatrixX stack_rows(const std::vector<VectorX>& rows) const {
    MatrixX stacked(static_cast<Index>(rows.size()), n_);
    for (std::size_t i = 0; i < rows.size(); ++i) stacked.row(static_cast<Index>(i)) = rows[i].transpose();
    return stacked;
  }

  static VectorX least_squares(const MatrixX& matrix, const VectorX& rhs) {
    numerics::CompleteOrthogonalDecomposition solver;
    solver.setThreshold(certificate_coefficient_tolerance);
    return solver.compute(matrix).solve(rhs);
  }

  std::optional<FarkasCertificate> verify(const VectorX& lambda) const {
    FarkasCertificate out{lambda, rows_.transpose() * lambda};
    const double trace = trace_.dot(lambda), size = numerics::max_abs(out.coefficients);
    if (!(trace > 0.5) || !(size < max_multiplier)) return std::nullopt;
    for (const Index p : cone_.excluded) {
      if (std::abs(out.coefficients[p]) > certificate_coefficient_tolerance * size) return std::nullopt;
      out.coefficients[p] = 0;
    }
    for (double& c : out.coefficients)
      if (std::abs(c) < eigenvalue_tolerance * size) c = 0;
    for (const PseudoInertiaBlock& block : cone_.blocks) {
      const numerics::SymmetricEigenSolver solver(block.matrix(out.coefficients), Eigen::EigenvaluesOnly);
      if (solver.eigenvalues()[0] < -eigenvalue_tolerance * size) return std::nullopt;
    }
    return out;
  }

  MatrixX rows_;
  const PseudoInertiaCone& cone_;
  Index n_;
  VectorX trace_;  ///< in λ: the sum of the traces of all bodies' matrices, normalised to one
  std::vector<Cut> cuts_;
};

}  // namespace

std::optional<FarkasCertificate> find_cone_certificate(const MatrixX& rows, const PseudoInertiaCone& cone) {
  return ConeCertificateSearch(rows, cone).find();
}

namespace {

/// Values of a linear program's solution below this, relative to the largest, are zero; the others are recomputed.
constexpr double program_zero_tolerance = 1e-7;

/// Up to this number of bodies, combinations around each single body are tried.
constexpr std::size_t max_single_body_searches = 20;

using Indices = std::vector<Eigen::Index>;

class SignCertificateSearch {
 public:
  SignCertificateSearch(const MatrixX& rows, const std::vector<Parameter>& parameters)
      : rows_(rows), n_(rows.rows()), sign_program_(2 * rows.rows()), sign_constrained_(VectorX::Zero(rows.cols())) {
    sign_program_.lower.setZero();
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const auto p = static_cast<Eigen::Index>(i);
      const ParameterSign sign = parameter_sign(parameters[i]);
      sign_program_.add_row(0, split(rows_.col(p)), sign == ParameterSign::indefinite ? 0 : numerics::no_bound);
      if (sign != ParameterSign::indefinite) sign_constrained_[p] = 1;
      if (sign == ParameterSign::positive) bodies_[parameters[i].index].push_back(p);
    }
  }

  std::optional<FarkasCertificate> find_sparsest() {
    Indices all_parameters;
    for (const auto& [body, parameters] : bodies_)
      all_parameters.insert(all_parameters.end(), parameters.begin(), parameters.end());
    if (!reduce_terms(all_parameters)) return std::nullopt;
    if (bodies_.size() <= max_single_body_searches)
      for (const auto& [body, parameters] : bodies_) reduce_terms(parameters);
    return best_;
  }

 private:
  /// Finds combinations in which the coefficients of some bodies' masses and moments of inertia add up to one. Weights
  /// that grow where a term is small drive small terms to zero (Candès, Wakin, Boyd, 2008).
  /// @return false if there are none
  bool reduce_terms(const Indices& selected) {
    LinearProgram program = sign_program_;
    program.add_row(1, split(rows_(Eigen::all, selected).rowwise().sum()), 1);
    VectorX weight = VectorX::Zero(rows_.cols());
    for (int round = 0; round < 4; ++round) {
      program.cost = split(rows_ * weight) + VectorX::Constant(2 * n_, round == 0 ? 1 : 0.01);
      const numerics::LinearProgramSolution solution = solve_linear_program(program);
      if (solution.status != numerics::LinearProgramStatus::optimal) return round > 0;
      const VectorX lambda = solution.x.head(n_) - solution.x.tail(n_);
      const std::optional<FarkasCertificate> certificate = refine(lambda);
      if (certificate && (!best_ || length(*certificate) < length(*best_))) best_ = certificate;
      const VectorX coefficients = rows_.transpose() * lambda;
      weight = sign_constrained_.array() / (coefficients.array().abs() + 1e-3);
    }
    return true;
  }

  /// λ = λ⁺ − λ⁻.
  static VectorX split(const VectorX& row) {
    VectorX split_row(2 * row.size());
    split_row << row, -row;
    return split_row;
  }

  static std::pair<Eigen::Index, Eigen::Index> length(const FarkasCertificate& certificate) {
    return {(certificate.coefficients.array() != 0).count(), (certificate.combination.array() != 0).count()};
  }

  /// The same combination to full accuracy: recombines the participating conditions such that coefficients that the
  /// program made zero vanish.
  std::optional<FarkasCertificate> refine(const VectorX& lambda) const {
    const VectorX coefficients = rows_.transpose() * lambda;
    const double size = numerics::max_abs(lambda);
    Indices active, vanishing, positive;
    for (Eigen::Index r = 0; r < n_; ++r)
      if (std::abs(lambda[r]) > program_zero_tolerance * size) active.push_back(r);
    for (Eigen::Index p = 0; p < rows_.cols(); ++p)
      (sign_constrained_[p] > 0 && coefficients[p] > program_zero_tolerance ? positive : vanishing).push_back(p);
    const numerics::SingularValueDecomposition svd(rows_(active, vanishing), Eigen::ComputeFullU);
    VectorX refined = lambda(active);
    for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
      if (svd.singularValues()[i] > certificate_coefficient_tolerance)
        refined -= svd.matrixU().col(i) * svd.matrixU().col(i).dot(refined);
    return verify(active, positive, refined);
  }

  std::optional<FarkasCertificate> verify(const Indices& active, const Indices& positive, const VectorX& lambda) const {
    FarkasCertificate out{VectorX::Zero(n_), VectorX::Zero(rows_.cols())};
    out.combination(active) = lambda;
    VectorX residual = rows_.transpose() * out.combination;
    for (const Eigen::Index p : positive) {
      if (!(residual[p] > 0)) return std::nullopt;
      std::swap(out.coefficients[p], residual[p]);
    }
    const double size = numerics::max_coefficient(out.coefficients);
    double body_sum = 0;
    for (const auto& [body, parameters] : bodies_) body_sum += out.coefficients(parameters).sum();
    if (!(body_sum > 1e-3 * size) || numerics::max_abs(residual) > certificate_coefficient_tolerance * size)
      return std::nullopt;
    return out;
  }

  MatrixX rows_;
  Eigen::Index n_;
  LinearProgram sign_program_;     ///< in λ⁺, λ⁻: every coefficient's sign
  VectorX sign_constrained_;       ///< 1 where the parameter cannot be negative
  std::map<int, Indices> bodies_;  ///< masses and moments of inertia per body
  std::optional<FarkasCertificate> best_;
};

}  // namespace

std::optional<FarkasCertificate> find_sign_certificate(const MatrixX& rows, const std::vector<Parameter>& parameters) {
  return SignCertificateSearch(rows, parameters).find_sparsest();
}

ParameterSign parameter_sign(const Parameter& parameter) {
  switch (parameter.kind) {
    case ParameterKind::known_term: return ParameterSign::positive;
    case ParameterKind::mass:
    case ParameterKind::moment_of_inertia:
      return parameter.owner_kind == dynamics::ParameterOwner::body ? ParameterSign::positive
                                                                    : ParameterSign::not_negative;
    case ParameterKind::stiffness:
    case ParameterKind::viscous:
    case ParameterKind::coulomb:
    case ParameterKind::tabulated: return ParameterSign::not_negative;
    case ParameterKind::first_moment:
    case ParameterKind::product_of_inertia:
    case ParameterKind::stiffness_moment:
    case ParameterKind::force:
    case ParameterKind::couple: return ParameterSign::indefinite;
  }
  return ParameterSign::indefinite;
}

bool is_always_zero(const Parameter& parameter) {
  return parameter.owner_kind == dynamics::ParameterOwner::disc && parameter.kind == ParameterKind::first_moment;
}

MatrixX PseudoInertiaBlock::matrix(const VectorX& coefficients) const {
  MatrixX sum = MatrixX::Zero(size, size);
  for (const Term& term : terms) sum += coefficients[term.parameter] * term.matrix;
  return sum;
}

VectorX PseudoInertiaBlock::bilinear_form_row(const VectorX& u, const VectorX& v, Eigen::Index parameters) const {
  VectorX row = VectorX::Zero(parameters);
  for (const Term& term : terms) row[term.parameter] = u.dot(term.matrix * v);
  return row;
}

namespace {

/// Index of a coordinate's letter.
Eigen::Index axis(char letter) { return letter - 'x'; }

/// A moment or product of inertia as a quadratic form in position: Ixx = ∫(y² + z²), Ixy = −∫xy, J = ∫(x² + y²).
MatrixX second_moment_form(std::string_view symbol, Eigen::Index dimension) {
  MatrixX form = MatrixX::Zero(dimension, dimension);
  if (symbol == "J") return MatrixX::Identity(dimension, dimension);
  const Eigen::Index i = axis(symbol[1]), j = axis(symbol[2]);
  if (i == j) {
    form.setIdentity();
    form(i, i) = 0;
  } else {
    form(i, j) = form(j, i) = -0.5;
  }
  return form;
}

/// The block of one body, attachment or disc with parameters first … last − 1. Its last row belongs to the constant 1.
PseudoInertiaBlock inertia_block(const std::vector<Parameter>& parameters, std::size_t first, std::size_t last) {
  const Eigen::Index dimension = last - first > 4 ? 3 : 2;
  PseudoInertiaBlock block{dimension + 1, parameters[first].owner_kind == dynamics::ParameterOwner::body, {}};
  for (std::size_t p = first; p < last; ++p) {
    const Parameter& parameter = parameters[p];
    if (is_always_zero(parameter)) continue;
    MatrixX form = MatrixX::Zero(dimension + 1, dimension + 1);
    if (parameter.kind == ParameterKind::mass) {
      form(dimension, dimension) = 1;
    } else if (parameter.kind == ParameterKind::first_moment) {
      const Eigen::Index i = axis(parameter.symbol[1]);
      form(i, dimension) = form(dimension, i) = 0.5;
    } else {
      form.topLeftCorner(dimension, dimension) = second_moment_form(parameter.symbol, dimension);
    }
    block.terms.push_back({static_cast<Eigen::Index>(p), form});
  }
  return block;
}

}  // namespace

PseudoInertiaCone::PseudoInertiaCone(const std::vector<Parameter>& parameters) {
  for (std::size_t first = 0; first < parameters.size();) {
    const Parameter& first_parameter = parameters[first];
    std::size_t last = first;
    while (last < parameters.size() && parameters[last].owner_kind == first_parameter.owner_kind &&
           parameters[last].index == first_parameter.index)
      ++last;
    if (first_parameter.kind == ParameterKind::known_term) {
      blocks.push_back({1, true, {{static_cast<Eigen::Index>(first), MatrixX::Ones(1, 1)}}});
    } else if (is_known_term(first_parameter)) {
      for (std::size_t p = first; p < last; ++p) excluded.push_back(static_cast<Eigen::Index>(p));
    } else if (first_parameter.owner_kind != dynamics::ParameterOwner::spring) {
      blocks.push_back(inertia_block(parameters, first, last));
    } else {
      blocks.push_back({1, false, {{static_cast<Eigen::Index>(first), MatrixX::Ones(1, 1)}}});
      for (std::size_t p = first + 1; p < last; ++p) excluded.push_back(static_cast<Eigen::Index>(p));
    }
    first = last;
  }
}

}  // namespace balance::conditions
