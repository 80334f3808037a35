// Semidefinite feasibility by cutting planes: a linear program knows each matrix Q by a few vectors v with vᵀQv ≥ 0, its solution's
// negative eigenvectors are new ones. If the program becomes infeasible there is no certificate. What it ends at is
// moved inwards where there is room, and where there is none (Q must be singular) put exactly on the cone's boundary.

#include "balance/synthesis/conditions/farkas_certificates.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

namespace balance {

std::optional<VectorX> find_bounds_certificate(const VectorX& constant, const MatrixX& gradient, const VectorX& lower,
                                               const VectorX& upper) {
  const Eigen::Index n = gradient.rows(), z = gradient.cols();
  // Unknowns: λ⁺, λ⁻ and the rates of the left-hand side split into rises and falls, gᵀ = λᵀ gradient = rise − fall. Where it
  // rises with z its least value is at the lower bound.
  LinearProgram program(2 * n + 2 * z);
  program.lower.setZero();
  program.cost.head(2 * n).setOnes();
  VectorX least(2 * n + 2 * z);
  least << constant, -constant, lower, -upper;
  for (Eigen::Index j = 0; j < z; ++j) {
    VectorX rate = VectorX::Zero(2 * n + 2 * z);
    rate.head(n) = gradient.col(j);
    rate.segment(n, n) = -gradient.col(j);
    rate[2 * n + j] = -1;
    rate[2 * n + z + j] = 1;
    program.add_row(0, rate, 0);
    if (lower[j] == -no_bound) program.upper[2 * n + j] = least[2 * n + j] = 0;
    if (upper[j] == no_bound) program.upper[2 * n + z + j] = least[2 * n + z + j] = 0;
  }
  program.add_row(1, least, no_bound);
  const LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status != LinearProgramStatus::optimal) return std::nullopt;
  return solution.x.head(n) - solution.x.segment(n, n);
}

namespace {

/// What an eigenvalue may fall short of zero, beside the largest of all matrices; conditions are not known better.
constexpr double eigenvalue_tolerance = 1e-10;
/// Room that is sought inside the cone, beside a matrix' size.
constexpr double interior_margin = 1e-3;
/// A matrix of this size stands for zero.
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
    const std::optional<VectorX> inside = search(inner_program(*start));
    for (const VectorX& candidate : {inside.value_or(*start), *start}) {
      if (std::optional<FarkasCertificate> found = verify(refine_at_tangency(candidate))) return found;
      for (const double singular : {1e-5, 1e-3, 1e-7, 0.0})
        if (std::optional<FarkasCertificate> found = verify(refine_by_newton(candidate, singular))) return found;
    }
    return std::nullopt;
  }

 private:
  struct Cut {
    std::size_t block;
    VectorX row;  ///< of λ: vᵀ Q v
  };

  /// The row by which λ gives uᵀ Q v.
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
    if (max_abs(row) > 0) cuts_.push_back({b, row});
  }

  /// Unknowns: λ⁺, λ⁻ and, per block, the room t with Q ≥ t.
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

  /// No room asked for, few conditions.
  LinearProgram first_program() const { return common_program(); }

  /// The same conditions and the same bodies, as much room as possible.
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

  /// Solves, cuts, solves again until no matrix is indefinite.
  std::optional<VectorX> search(LinearProgram program) {
    std::size_t known = 0;
    for (int round = 0; round < max_cutting_plane_rounds; ++round) {
      for (; known < cuts_.size(); ++known) program.add_row(0, program_row(cuts_[known].row, &cuts_[known]), no_bound);
      const LinearProgramSolution solution = solve_linear_program(program);
      if (solution.status != LinearProgramStatus::optimal) return std::nullopt;
      VectorX lambda = solution.x.head(n_) - solution.x.segment(n_, n_);
      for (double& factor : lambda)
        if (std::abs(factor) < certificate_coefficient_tolerance) factor = 0;
      if (!add_eigenvector_cuts(lambda, solution.x.tail(blocks()))) return lambda;
    }
    return std::nullopt;
  }

  /// @return false if there was nothing to cut off
  bool add_eigenvector_cuts(const VectorX& lambda, const VectorX& inside) {
    const VectorX coefficients = rows_.transpose() * lambda;
    const std::size_t before = cuts_.size();
    for (std::size_t b = 0; b < cone_.blocks.size(); ++b) {
      const SymmetricEigenSolver solver(cone_.blocks[b].matrix(coefficients));
      for (Index i = 0; i < solver.eigenvalues().size(); ++i)
        if (solver.eigenvalues()[i] < inside[static_cast<Index>(b)] - 10 * certificate_coefficient_tolerance)
          add_cut(b, solver.eigenvectors().col(i));
    }
    return cuts_.size() > before;
  }

  /// Newton's method on: what is excluded is zero, the trace is one, matrices of size zero vanish, and eigenvalues below
  /// `singular` (relative to their matrix) are zero.
  VectorX refine_by_newton(VectorX lambda, double singular) const {
    const std::vector<Index> part = active_conditions(lambda);
    for (int round = 0; round < 8; ++round) {
      const VectorX coefficients = rows_.transpose() * lambda;
      std::vector<VectorX> rows = equations(coefficients);
      for (const PseudoInertiaBlock& block : cone_.blocks) {
        const Spectrum spectrum(block, coefficients, singular);
        for (Index i = 0; i < spectrum.null; ++i)
          for (Index k = 0; k <= i; ++k) rows.push_back(form(block, spectrum.vectors.col(i), spectrum.vectors.col(k)));
      }
      const MatrixX jacobian = stack_rows(rows);
      VectorX residual = -jacobian * lambda;
      residual[0] += 1;
      lambda(part) += least_squares(jacobian(Eigen::all, part), residual);
    }
    return lambda;
  }

  /// Where the family of matrices only touches the cone its smallest eigenvalues are zero at their maximum, and Newton's method
  /// on their values is blind: this is Newton's method on the gradient of their sum, everything else kept.
  VectorX refine_at_tangency(VectorX lambda) const {
    const std::vector<Index> part = active_conditions(lambda);
    for (int round = 0; round < 3; ++round) {
      const VectorX coefficients = rows_.transpose() * lambda;
      VectorX gradient = VectorX::Zero(n_);
      MatrixX hessian = MatrixX::Zero(n_, n_);
      for (const PseudoInertiaBlock& block : cone_.blocks) {
        const Spectrum s(block, coefficients, 1e-5);
        for (Index a = 0; a < s.null; ++a) {
          gradient += form(block, s.vectors.col(a), s.vectors.col(a));
          for (Index b = s.null; b < block.size; ++b) {
            const VectorX mixed = form(block, s.vectors.col(a), s.vectors.col(b));
            hessian -= 2 / (s.values[b] - s.values[a]) * mixed * mixed.transpose();
          }
        }
      }
      const Eigen::FullPivLU<MatrixX> kept(stack_rows(equations(coefficients))(Eigen::all, part));
      const MatrixX free = kept.kernel();
      if (free.isZero(0)) break;
      const MatrixX curvature = free.transpose() * hessian(part, part) * free;
      lambda(part) -= free * least_squares(curvature, free.transpose() * gradient(part));
    }
    return lambda;
  }

  /// Eigenvalues, increasing, and how many of them are zero.
  struct Spectrum {
    VectorX values;
    MatrixX vectors;
    Index null = 0;

    Spectrum(const PseudoInertiaBlock& block, const VectorX& coefficients, double singular) {
      const MatrixX matrix = block.matrix(coefficients);
      const double size = matrix.norm();
      const SymmetricEigenSolver solver(matrix);
      values = solver.eigenvalues(), vectors = solver.eigenvectors();
      if (size >= zero_matrix_tolerance) null = (values.array() < singular * size).count();
      if (singular == 0) null = 0;
    }
  };

  static std::vector<Index> active_conditions(const VectorX& lambda) {
    std::vector<Index> part;
    for (Index r = 0; r < lambda.size(); ++r)
      if (lambda[r] != 0) part.push_back(r);
    return part;
  }

  /// Rows of λ that give the trace, what is excluded, and the entries of matrices that vanish.
  std::vector<VectorX> equations(const VectorX& coefficients) const {
    std::vector<VectorX> rows = {trace_};
    for (const Index p : cone_.excluded) rows.emplace_back(rows_.col(p));
    for (const PseudoInertiaBlock& block : cone_.blocks)
      if (block.matrix(coefficients).norm() < zero_matrix_tolerance)
        for (const PseudoInertiaBlock::Term& term : block.terms) rows.emplace_back(rows_.col(term.parameter));
    return rows;
  }

  MatrixX stack_rows(const std::vector<VectorX>& rows) const {
    MatrixX all(static_cast<Index>(rows.size()), n_);
    for (std::size_t i = 0; i < rows.size(); ++i) all.row(static_cast<Index>(i)) = rows[i].transpose();
    return all;
  }

  static VectorX least_squares(const MatrixX& matrix, const VectorX& right) {
    CompleteOrthogonalDecomposition solver;
    solver.setThreshold(certificate_coefficient_tolerance);
    return solver.compute(matrix).solve(right);
  }

  std::optional<FarkasCertificate> verify(const VectorX& lambda) const {
    FarkasCertificate out{lambda, rows_.transpose() * lambda};
    const double bodies = trace_.dot(lambda), size = max_abs(out.coefficients);
    if (!(bodies > 0.5) || !(size < max_multiplier)) return std::nullopt;
    for (const Index p : cone_.excluded) {
      if (std::abs(out.coefficients[p]) > certificate_coefficient_tolerance * size) return std::nullopt;
      out.coefficients[p] = 0;
    }
    for (double& c : out.coefficients)
      if (std::abs(c) < eigenvalue_tolerance * size) c = 0;
    for (const PseudoInertiaBlock& block : cone_.blocks) {
      const SymmetricEigenSolver solver(block.matrix(out.coefficients), Eigen::EigenvaluesOnly);
      if (solver.eigenvalues()[0] < -eigenvalue_tolerance * size) return std::nullopt;
    }
    return out;
  }

  MatrixX rows_;
  const PseudoInertiaCone& cone_;
  Index n_;
  VectorX trace_;  ///< of λ: the sum of the traces of all bodies' matrices, normalised to one
  std::vector<Cut> cuts_;
};

}  // namespace

std::optional<FarkasCertificate> find_cone_certificate(const MatrixX& rows, const PseudoInertiaCone& cone) {
  return ConeCertificateSearch(rows, cone).find();
}

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

ParameterSign parameter_sign(const Parameter& parameter) {
  switch (parameter.kind) {
    case ParameterKind::known_term: return ParameterSign::positive;
    case ParameterKind::mass:
    case ParameterKind::moment_of_inertia:
      return parameter.owner_kind == ParameterOwner::body ? ParameterSign::positive : ParameterSign::not_negative;
    case ParameterKind::stiffness:
    case ParameterKind::viscous:
    case ParameterKind::coulomb: return ParameterSign::not_negative;
    case ParameterKind::first_moment:
    case ParameterKind::product_of_inertia:
    case ParameterKind::stiffness_moment:
    case ParameterKind::force:
    case ParameterKind::couple: return ParameterSign::indefinite;
  }
  return ParameterSign::indefinite;
}

bool is_always_zero(const Parameter& parameter) {
  return parameter.owner_kind == ParameterOwner::disc && parameter.kind == ParameterKind::first_moment;
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

/// Place of a letter among the coordinates.
Eigen::Index axis(char letter) { return letter - 'x'; }

/// The quadratic part of a moment or product of inertia, as a form in the place: Ixx = ∫(y² + z²), Ixy = −∫xy, J = ∫(x² + y²).
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

/// The block of one body, attachment or disc with the parameters first … last − 1. The last row belongs to the constant 1.
PseudoInertiaBlock inertia_block(const std::vector<Parameter>& parameters, std::size_t first, std::size_t last) {
  const Eigen::Index dimension = last - first > 4 ? 3 : 2;
  PseudoInertiaBlock block{dimension + 1, parameters[first].owner_kind == ParameterOwner::body, {}};
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
    const Parameter& head = parameters[first];
    std::size_t last = first;
    while (last < parameters.size() && parameters[last].owner_kind == head.owner_kind &&
           parameters[last].index == head.index)
      ++last;
    if (head.kind == ParameterKind::known_term) {
      blocks.push_back({1, true, {{static_cast<Eigen::Index>(first), MatrixX::Ones(1, 1)}}});
    } else if (head.owner_kind == ParameterOwner::load || head.owner_kind == ParameterOwner::friction) {
      for (std::size_t p = first; p < last; ++p) excluded.push_back(static_cast<Eigen::Index>(p));
    } else if (head.owner_kind != ParameterOwner::spring) {
      blocks.push_back(inertia_block(parameters, first, last));
    } else {
      blocks.push_back({1, false, {{static_cast<Eigen::Index>(first), MatrixX::Ones(1, 1)}}});
      for (std::size_t p = first + 1; p < last; ++p) excluded.push_back(static_cast<Eigen::Index>(p));
    }
    first = last;
  }
}

}  // namespace balance
