#include "balance/synthesis/design/tie_follower.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/feasible_directions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace balance::design {

namespace {

/// Values within this part of the figure below a maximum take part in it: the accuracy of a search.
constexpr double active_value_tolerance = 1e-6;
/// Step in unit coordinates, and the relative change of the figure beyond which it does not stay the same: a curvature
/// of a thousandth of the figure.
constexpr double follow_step = 1e-3, follow_value_tolerance = 1e-9;
/// Decrease of the figure, relative to it, that its derivatives promise within a follow_step of a point that is not
/// stationary.
constexpr double stationarity_tolerance = 1e-5;
/// Residual of conditions that were restored.
constexpr double restored_residual_tolerance = 1e-9;
constexpr Eigen::Index max_followed_directions = 4;
constexpr int max_follow_iterations = 8;

bool is_active(const MaxTerm& term, Eigen::Index k, double scale) {
  return std::abs(term.weight) * (numerics::max_coefficient(term.values) - term.values[k]) <=
         active_value_tolerance * scale;
}

}  // namespace

TieFollower::TieFollower(const SolverContext& context, const ScaledObjective& objective, Terms terms,
                         const Conditions& conditions, const VectorX& u)
    : context_(context), objective_(objective), terms_at_(std::move(terms)), conditions_(conditions), u_(u) {
  value_ = objective_(u_, nullptr);
  terms_ = terms_at_(u_);
  if (terms_ && terms_->empty()) terms_.reset();
  if (!terms_) return;
  scale_ = std::abs(value_);
  double sum = 0;
  bool is_sum_of_maxima = true;
  for (const MaxTerm& term : *terms_) {
    is_sum_of_maxima = is_sum_of_maxima && term.values.size() > 0 && (term.weight >= 0 || term.values.size() == 1);
    if (!is_sum_of_maxima) break;
    sum += term.weight * numerics::max_coefficient(term.values);
    for (Eigen::Index k = 0; k < term.values.size(); ++k)
      scale_ = std::max(scale_, follow_step * std::abs(term.weight) * term.jacobian.row(k).norm());
  }
  if (!is_sum_of_maxima || !(scale_ > 0) || !(std::abs(sum - value_) <= active_value_tolerance * scale_))
    terms_.reset();
}

std::optional<MatrixX> TieFollower::find_directions(const MatrixX& free, const MatrixX& known,
                                                    const MatrixX& limits) const {
  if (!terms_ || !is_stationary(free, limits)) return std::nullopt;
  const MatrixX ties = span_first_order_ties(free, limits);
  const MatrixX rest = restrict_to_null_space(ties, known.transpose(), null_space_tolerance);
  const std::optional<MatrixX> others = test_by_values(rest, limits);
  if (!others) return std::nullopt;
  MatrixX all(u_.size(), known.cols() + others->cols());
  all << known, *others;
  return all;
}

/// The smallest value of the figure's linear model within a small step, by the unknowns z of the step and a bound of the
/// change of each maximum.
bool TieFollower::is_stationary(const MatrixX& free, const MatrixX& limits) const {
  const Eigen::Index n = free.cols(), maxima = static_cast<Eigen::Index>(terms_->size());
  if (n == 0) return true;
  numerics::LinearProgram program(n + maxima);
  const auto add = [&](double low, const VectorX& by_step, double high) {
    VectorX row = VectorX::Zero(n + maxima);
    row.head(n) = by_step;
    program.add_row(low, row, high);
  };
  for (Eigen::Index i = 0; i < u_.size(); ++i)
    add(std::max(-1 - u_[i], -follow_step) / follow_step, free.row(i).transpose(),
        std::min(1 - u_[i], follow_step) / follow_step);
  for (Eigen::Index k = 0; k < limits.rows(); ++k)
    add(0, (limits.row(k) * free).transpose() / std::max(limits.row(k).norm(), 1e-300), numerics::no_bound);
  for (Eigen::Index j = 0; j < maxima; ++j) {
    const MaxTerm& term = (*terms_)[static_cast<std::size_t>(j)];
    program.cost[n + j] = 1;
    const double highest = numerics::max_coefficient(term.values);
    for (Eigen::Index k = 0; k < term.values.size(); ++k) {
      VectorX row = VectorX::Zero(n + maxima);
      row.head(n) = -term.weight * follow_step * (term.jacobian.row(k) * free).transpose() / scale_;
      row[n + j] = 1;
      program.add_row(term.weight * (term.values[k] - highest) / scale_, row, numerics::no_bound);
    }
  }
  const numerics::LinearProgramSolution solution = solve_linear_program(program);
  return solution.status == numerics::LinearProgramStatus::optimal &&
         -program.cost.dot(solution.x) * scale_ <=
             stationarity_tolerance * std::abs(value_) + active_value_tolerance * scale_;
}

/// The span of the feasible directions in which no active value of a maximum, and so the figure, increases.
MatrixX TieFollower::span_first_order_ties(const MatrixX& free, const MatrixX& limits) const {
  const Eigen::Index n = u_.size(), maxima = static_cast<Eigen::Index>(terms_->size());
  std::vector<VectorX> rows;
  const auto zero_row = [&] { return VectorX(VectorX::Zero(n + maxima)); };
  for (Eigen::Index k = 0; k < limits.rows(); ++k) {
    rows.push_back(zero_row());
    rows.back().head(n) = limits.row(k).transpose();
  }
  // bounds of the changes: each is at least that of every active value, and their sum is not positive
  VectorX sum = zero_row();
  for (Eigen::Index j = 0; j < maxima; ++j) {
    const MaxTerm& term = (*terms_)[static_cast<std::size_t>(j)];
    sum[n + j] = -1;
    for (Eigen::Index k = 0; k < term.values.size(); ++k) {
      if (!is_active(term, k, scale_)) continue;
      rows.push_back(zero_row());
      rows.back().head(n) = -term.weight * term.jacobian.row(k).transpose() / scale_;
      rows.back()[n + j] = 1;
    }
  }
  rows.push_back(sum);
  MatrixX normals(static_cast<Eigen::Index>(rows.size()), n + maxima);
  for (std::size_t k = 0; k < rows.size(); ++k) normals.row(static_cast<Eigen::Index>(k)) = rows[k].transpose();
  MatrixX basis = MatrixX::Zero(n + maxima, free.cols() + maxima);
  basis.topLeftCorner(n, free.cols()) = free;
  basis.bottomRightCorner(maxima, maxima).setIdentity();
  const MatrixX span = span_feasible_directions(basis, normals).topRows(n);
  if (span.cols() == 0) return span;
  const numerics::SingularValueDecomposition svd(span, Eigen::ComputeFullU);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > null_space_tolerance) ++rank;
  return svd.matrixU().leftCols(rank);
}

/// @param directions orthonormal
std::optional<MatrixX> TieFollower::test_by_values(const MatrixX& directions, const MatrixX& limits) const {
  if (directions.cols() == 0) return directions;
  if (directions.cols() > max_followed_directions) return std::nullopt;
  std::vector<VectorX> ties;
  // those that leave a limit have one sense only
  const MatrixX two_sided = restrict_to_null_space(directions, limits, null_space_tolerance);
  const MatrixX one_sided = restrict_to_null_space(directions, two_sided.transpose(), null_space_tolerance);
  for (Eigen::Index k = 0; k < one_sided.cols(); ++k) {
    const VectorX slopes = limits * one_sided.col(k);
    const double sense = numerics::max_coefficient(slopes) > -numerics::min_coefficient(slopes) ? 1 : -1;
    const VectorX inwards = sense * one_sided.col(k);
    if (numerics::min_coefficient(VectorX(limits * inwards)) < -null_space_tolerance) return std::nullopt;
    const Change change = change_along(follow_step * inwards);
    if (change == Change::unknown || change == Change::fall) return std::nullopt;
    if (change == Change::none) ties.push_back(inwards);
  }
  const MatrixX principal = two_sided.cols() > 1 ? find_principal_directions(two_sided) : two_sided;
  for (Eigen::Index k = 0; k < principal.cols(); ++k) {
    const Change ahead = change_along(follow_step * principal.col(k)),
                 behind = change_along(-follow_step * principal.col(k));
    for (const Change change : {ahead, behind})
      if (change == Change::unknown || change == Change::fall) return std::nullopt;
    if (ahead == Change::none || behind == Change::none) ties.emplace_back(principal.col(k));
  }
  if (principal.cols() < two_sided.cols()) return std::nullopt;
  MatrixX all(u_.size(), static_cast<Eigen::Index>(ties.size()));
  for (std::size_t k = 0; k < ties.size(); ++k) all.col(static_cast<Eigen::Index>(k)) = ties[k];
  return all;
}

/// Eigenvectors of the figure's second differences along the restored steps; none if it has no values there.
MatrixX TieFollower::find_principal_directions(const MatrixX& basis) const {
  const Eigen::Index n = basis.cols();
  const auto second_difference = [&](const VectorX& d) {
    return value_difference(follow_step * d) + value_difference(-follow_step * d);
  };
  MatrixX curvature(n, n);
  for (Eigen::Index i = 0; i < n; ++i) curvature(i, i) = second_difference(basis.col(i));
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      curvature(i, j) = curvature(j, i) =
          (second_difference(basis.col(i) + basis.col(j)) - curvature(i, i) - curvature(j, j)) / 2;
  if (!curvature.allFinite()) return MatrixX(basis.rows(), 0);
  return basis * numerics::SymmetricEigenSolver(curvature).eigenvectors();
}

TieFollower::Change TieFollower::change_along(const VectorX& step) const {
  const double difference = value_difference(step), tolerance = follow_value_tolerance * scale_;
  if (!std::isfinite(difference)) return Change::unknown;
  return difference > tolerance ? Change::rise : difference < -tolerance ? Change::fall : Change::none;
}

/// The change of the figure along a step and back to the maxima, conditions and limits of the design; NaN if that fails.
double TieFollower::value_difference(const VectorX& step) const {
  constexpr double not_defined = std::numeric_limits<double>::quiet_NaN();
  if (context_.budget.is_interrupted() || numerics::max_abs(VectorX(u_ + step)) > 1 + 1e-9) return not_defined;
  try {
    const VectorX at = restore(clip_to_unit_box(u_ + step));
    const bool has_moved = (at - u_).norm() > step.norm() / 2;
    if (!has_moved || !context_.is_admissible(at) || !context_.infeasibility_reason(at).empty()) return not_defined;
    if (!context_.problem.goals.empty()) {
      const Conditions conditions = context_.classification.has_geometric() ? context_.conditions_at(at) : conditions_;
      if (conditions.status != ConditionsStatus::done) return not_defined;
      const VectorX residuals =
          scaled_residuals(conditions, conditions::term_values(context_.mechanism(at), context_.options.loose_springs));
      if (residuals.size() > 0 && !(numerics::max_abs(residuals) < restored_residual_tolerance)) return not_defined;
    }
    return objective_(at, nullptr) - value_;
  } catch (const SpecError&) {
    return not_defined;
  } catch (const std::invalid_argument&) {
    return not_defined;
  }
}

VectorX TieFollower::restore(const VectorX& from) const {
  const ConditionResidual masses(context_, conditions_);
  numerics::NonlinearSystem geometry;
  if (context_.classification.has_geometric() && conditions_.matrix.rows() > 0)
    geometry = make_equations_near(context_, u_, {});
  VectorX g;
  if (context_.limits->size() > 0) context_.limits->evaluate(u_, g, nullptr);
  std::vector<Eigen::Index> active_limits;
  for (Eigen::Index k = 0; k < g.size(); ++k)
    if (g[k] < active_value_tolerance) active_limits.push_back(k);

  numerics::NonlinearSystem equations;
  equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
    std::vector<double> residuals;
    std::vector<VectorX> slopes;
    const auto add = [&](double value, const MatrixX& by_number, Eigen::Index row) {
      residuals.push_back(value);
      if (jacobian != nullptr) slopes.emplace_back(by_number.row(row).transpose());
    };
    VectorX block;
    MatrixX by_number;
    if (geometry.evaluate) {
      if (!geometry.evaluate(v, block, jacobian != nullptr ? &by_number : nullptr)) return false;
      for (Eigen::Index k = 0; k < geometry.primary_rows; ++k) add(block[k], by_number, k);
    } else {
      masses.evaluate(v, block, jacobian != nullptr ? &by_number : nullptr);
      for (Eigen::Index k = 0; k < block.size(); ++k) add(block[k], by_number, k);
    }
    if (!active_limits.empty()) {
      context_.limits->evaluate(v, block, jacobian != nullptr ? &by_number : nullptr);
      for (const Eigen::Index k : active_limits) add(block[k] - g[k], by_number, k);
    }
    const std::optional<std::vector<MaxTerm>> terms = terms_at_(v);
    if (!terms) return false;
    for (std::size_t j = 0; j < terms->size(); ++j) {
      const MaxTerm &at_design = (*terms_)[j], &term = (*terms)[j];
      if (at_design.values.size() < 2) continue;  // a smooth figure is not restored
      if (term.values.size() != at_design.values.size()) return false;
      const double factor = term.weight / scale_;
      for (Eigen::Index k = 0; k < term.values.size(); ++k)
        if (is_active(at_design, k, scale_))
          add(factor * (term.values[k] - at_design.values[k]), MatrixX(factor * term.jacobian.row(k)), 0);
    }
    values = Eigen::Map<const VectorX>(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
    if (jacobian != nullptr) {
      jacobian->resize(values.size(), v.size());
      for (std::size_t k = 0; k < slopes.size(); ++k)
        jacobian->row(static_cast<Eigen::Index>(k)) = slopes[k].transpose();
    }
    return values.allFinite();
  };
  VectorX values;
  if (!equations.evaluate(from, values, nullptr) || values.size() == 0) return from;
  equations.primary_rows = equations.row_count = static_cast<int>(values.size());
  return solve_levenberg_marquardt(equations, from, max_follow_iterations).u;
}

}  // namespace balance::design
