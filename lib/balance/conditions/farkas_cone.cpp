// Semidefinite feasibility by cutting planes: a linear program knows each matrix Q by a few vectors v with vᵀQv ≥ 0, its solution's
// negative eigenvectors are new ones. If the program becomes infeasible there is no certificate. What it ends at is
// moved inwards where there is room, and where there is none (Q must be singular) put exactly on the cone's boundary.

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/conditions/farkas.hpp"
#include "balance/conditions/linear_program.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance {

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

}  // namespace balance
