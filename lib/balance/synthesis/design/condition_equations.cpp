#include "balance/synthesis/design/condition_equations.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/bounded_least_squares.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/quadratic_program.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace balance::design {

using numerics::NonlinearSystem;

namespace {

/// Weight of a violated inequality relative to the scaled residuals.
constexpr double violation_weight = 1;

/// Fills rows with min(0, g).
void append_violations(const SolverContext& context, const VectorX& u, Eigen::Index first, VectorX& values,
                       MatrixX* jacobian) {
  VectorX g;
  MatrixX dg;
  context.evaluate_inequalities(u, g, jacobian != nullptr ? &dg : nullptr);
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    values[first + k] = violation_weight * std::min(0.0, g[k]);
    if (jacobian == nullptr) continue;
    if (g[k] < 0)
      jacobian->row(first + k) = violation_weight * dg.row(k);
    else
      jacobian->row(first + k).setZero();
  }
}

/// Residual of the conditions at one geometry that does not depend on the choice of pivots: the projection of the
/// parameters on the row space, in units that make parameters of different dimension comparable.
bool project_on_row_space(const SolverContext& context, const Mechanism& mechanism, const VectorX& unit,
                          VectorX& residual) {
  const Conditions conditions = context.derive_conditions(mechanism);
  if (conditions.status != ConditionsStatus::done) return false;
  const VectorX parameters = conditions::term_values(mechanism, context.options.loose_springs).cwiseQuotient(unit);
  residual.setZero(parameters.size());
  if (conditions.parameter_rows() == 0) return true;
  const MatrixX columns = (conditions.matrix.topRows(conditions.parameter_rows()) * unit.asDiagonal()).transpose();
  const Eigen::HouseholderQR<MatrixX> qr(columns);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(columns.rows(), columns.cols());
  residual = q * (q.transpose() * parameters);
  return true;
}

}  // namespace

ConditionResidual::ConditionResidual(const SolverContext& context, const Conditions& conditions) : context_(context) {
  matrix_.setZero(conditions.matrix.rows(), context.features.feature_count());
  for (Eigen::Index k = 0; k < matrix_.rows(); ++k)
    matrix_.row(k).head(conditions.matrix.cols()) = conditions.matrix.row(k) / conditions.row_scales[k];
  if (context.features.polynomial()) polynomial_ = context.features.polynomial()->combine(matrix_);
}

bool ConditionResidual::has_variable(int row, int variable) const {
  if (polynomial_) return polynomial_->has_variable(row, variable);
  const VariableClassification& classification = context_.classification;
  const VectorX &before = classification.base_features,
                &after = classification.perturbed_features[static_cast<std::size_t>(variable)];
  const double size = matrix_.row(row).cwiseAbs().dot(before.cwiseAbs().cwiseMax(after.cwiseAbs()));
  return std::abs(matrix_.row(row).dot(after - before)) > classification.change_threshold * size;
}

bool ConditionResidual::is_affine(const std::vector<int>& rows) const {
  return polynomial_ && std::all_of(rows.begin(), rows.end(), [&](int row) { return polynomial_->is_affine(row); });
}

void ConditionResidual::evaluate(const VectorX& u, VectorX& residual, MatrixX* jacobian) const {
  if (polynomial_) {
    polynomial_->evaluate(u, residual, jacobian);
    return;
  }
  VectorX values;
  MatrixX slopes;
  context_.features.evaluate(u, values, jacobian != nullptr ? &slopes : nullptr);
  residual = matrix_ * values;
  if (jacobian != nullptr) *jacobian = matrix_ * slopes;
}

VectorX ConditionResidual::evaluate_from_mechanism(const VectorX& u) const {
  return matrix_ * context_.features.evaluate_from_mechanism(u);
}

double ConditionResidual::lower_bound(const VectorX& factors) const {
  if (!polynomial_) return -std::numeric_limits<double>::infinity();
  return polynomial_->combine(factors.transpose()).lower_bound(0);
}

NonlinearSystem make_fixed_geometry_equations(const SolverContext& context, const ConditionResidual& rows,
                                              std::vector<int> selected_rows, VectorX target) {
  NonlinearSystem equations;
  equations.primary_rows = static_cast<int>(selected_rows.size());
  equations.row_count = equations.primary_rows + context.inequality_count();
  equations.evaluate = [&context, &rows, selected_rows = std::move(selected_rows), target = std::move(target),
                        total = equations.row_count](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX all;
    MatrixX slopes;
    rows.evaluate(u, all, jacobian != nullptr ? &slopes : nullptr);
    values.resize(total);
    values.head(target.size()) = all(selected_rows) - target;
    if (jacobian != nullptr) {
      jacobian->resize(total, u.size());
      jacobian->topRows(target.size()) = slopes(selected_rows, Eigen::all);
    }
    if (context.inequality_count() > 0) append_violations(context, u, target.size(), values, jacobian);
    return values.allFinite();
  };
  return equations;
}

namespace {

/// The residual of the goals at fixed configurations, as a function of all free numbers.
class GeometryResidual {
 public:
  GeometryResidual(const SolverContext& context, const Mechanism& start) : context_(context) {
    if (context.problem.derives_anew)
      unit_ = parameter_scales(start, context.options.loose_springs);
    else
      goal_.emplace(start, context.problem.goals, context.options);
  }

  /// @param jacobian rows × variables, by differences, or null
  /// @return false if the residual cannot be evaluated
  bool evaluate(const VectorX& u, VectorX& residual, MatrixX* jacobian) {
    // Gauss–Newton gains seven digits per step near the end.
    constexpr double geometry_difference_step = 1e-7;
    if (!evaluate_at(u, residual)) return false;
    if (jacobian == nullptr) return true;
    jacobian->resize(residual.size(), u.size());
    VectorX ahead;
    // numbers that leave the rows as they are come first, as the rows are at hand
    for (const bool is_geometric : {false, true})
      for (Eigen::Index i = 0; i < u.size(); ++i) {
        if (context_.classification.is_geometric[static_cast<std::size_t>(i)] != is_geometric) continue;
        VectorX v = u;
        v[i] += u[i] > 0 ? -geometry_difference_step : geometry_difference_step;
        if (!evaluate_at(v, ahead) || ahead.size() != residual.size()) return false;
        jacobian->col(i) = (ahead - residual) / (v[i] - u[i]);
      }
    return true;
  }

 private:
  bool evaluate_at(const VectorX& u, VectorX& residual) {
    try {
      if (context_.budget.is_past_deadline()) return false;
      const Mechanism mechanism = context_.mechanism(u);
      if (!goal_) return project_on_row_space(context_, mechanism, unit_, residual) && residual.allFinite();
      if (!update_rows(u, mechanism)) return false;
      residual = rows_ * conditions::term_values(mechanism, context_.options.loose_springs);
      return residual.allFinite();
    } catch (const SpecError&) {
      return false;  // an expression of the spec has no value here
    }
  }

  /// The rows depend on lengths and ratios alone.
  bool update_rows(const VectorX& u, const Mechanism& mechanism) {
    VectorX geometry = u;
    for (Eigen::Index i = 0; i < u.size(); ++i)
      if (!context_.classification.is_geometric[static_cast<std::size_t>(i)]) geometry[i] = 0;
    if (geometry_.size() > 0 && geometry == geometry_) return true;
    geometry_.resize(0);
    if (!goal_->rows(mechanism, rows_)) return false;
    geometry_ = geometry;
    return true;
  }

  const SolverContext& context_;
  VectorX unit_;
  std::optional<conditions::GoalResidual> goal_;
  MatrixX rows_;      ///< residual per unit of every term
  VectorX geometry_;  ///< at which the rows were evaluated; empty: not yet
};

}  // namespace

NonlinearSystem make_geometry_equations(const SolverContext& context, const VectorX& from) {
  // shared_ptr because std::function must be copyable; there is only one owner
  const auto residual = std::make_shared<GeometryResidual>(context, context.mechanism(from));
  VectorX first;
  NonlinearSystem equations;
  equations.primary_rows = residual->evaluate(from, first, nullptr) ? static_cast<int>(first.size()) : 0;
  equations.row_count = equations.primary_rows + context.inequality_count();
  equations.evaluate = [&context, residual, count = equations.primary_rows, total = equations.row_count](
                           const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX r;
    MatrixX slopes;
    if (!residual->evaluate(u, r, jacobian != nullptr ? &slopes : nullptr) || r.size() != count) return false;
    values.resize(total);
    values.head(count) = r;
    if (jacobian != nullptr) {
      jacobian->resize(total, u.size());
      jacobian->topRows(count) = slopes;
    }
    if (context.inequality_count() > 0) append_violations(context, u, count, values, jacobian);
    return values.allFinite() && (jacobian == nullptr || jacobian->allFinite());
  };
  return equations;
}

NonlinearSystem make_equations_near(const SolverContext& context, const VectorX& u, const NonlinearSystem& otherwise) {
  if (otherwise.primary_rows == 0) return otherwise;
  try {
    NonlinearSystem equations = make_geometry_equations(context, u);
    if (equations.primary_rows > 0) return equations;
  } catch (const SpecError&) {
    // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    // the mechanism has no configuration to evaluate conditions at
  }
  return otherwise;
}

double max_condition_residual(const NonlinearSystem& equations, const VectorX& values) {
  return equations.primary_rows > 0 ? numerics::max_abs(values.head(equations.primary_rows)) : 0;
}

namespace {

/// Rank tolerance of affine conditions, relative to the largest singular value.
constexpr double condition_rank_tolerance = 1e-10;

/// Number of starts without a new solution after which the search ends, or after which infeasibility is tested.
constexpr int max_stall_starts = 8;
/// Maximum number of solutions kept although they are not usable; they explain the failure.
constexpr std::size_t max_rejected_solutions = 3;
/// Variables this close to a bound, their start value or zero are candidates for snapping.
constexpr double rounding_tolerance = 1e-8;
/// Residuals below this count as zero.
constexpr double residual_epsilon = 1e-15;

bool is_new_solution(const std::vector<VectorX>& known, const VectorX& u) {
  return std::none_of(known.begin(), known.end(), [&](const VectorX& k) { return numerics::max_abs(k - u) < 1e-6; });
}

}  // namespace

LinearConditions linear_conditions(const NonlinearSystem& equations, int numbers) {
  VectorX values;
  MatrixX jacobian;
  const VectorX origin = VectorX::Zero(numbers);
  equations.evaluate(origin, values, &jacobian);
  if (equations.primary_rows == 0) return {MatrixX(0, numbers), VectorX(0)};
  const MatrixX rows = jacobian.topRows(equations.primary_rows);
  const numerics::SingularValueDecomposition svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorX& s = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < s.size() && s[rank] > condition_rank_tolerance * s[0]) ++rank;
  const VectorX rhs = -(svd.matrixU().transpose() * values.head(equations.primary_rows));
  return {svd.matrixV().leftCols(rank).transpose(), rhs.head(rank).cwiseQuotient(s.head(rank))};
}

bool is_exact(const SolverContext& context, const NonlinearSystem& equations, const VectorX& u) {
  VectorX values;
  return equations.evaluate(u, values, nullptr) && max_condition_residual(equations, values) < condition_tolerance &&
         context.is_admissible(u);
}

ExactSolutions find_exact_solutions(const SolverContext& context, const NonlinearSystem& equations,
                                    const ExactSearchOptions& options) {
  ExactSolutions result;
  numerics::UniformRandom random(context.problem.search.seed);
  int stalled_starts = 0;  // number of starts since the last new solution
  const std::vector<VectorX> starts =
      options.starts.empty() ? std::vector<VectorX>{context.scaling.start()} : options.starts;
  const int given_start_count = static_cast<int>(starts.size());
  for (int k = 0; k < given_start_count + options.max_restarts &&
                  static_cast<int>(result.solutions.size()) < options.max_solutions;
       ++k) {
    if (k > 0 && context.budget.is_spent()) break;
    if (stalled_starts++ == max_stall_starts &&
        (!result.solutions.empty() ||
         (result.rejected.empty() && options.is_proved_infeasible && options.is_proved_infeasible())))
      break;
    const VectorX from =
        k < given_start_count ? starts[static_cast<std::size_t>(k)] : random.sample_point(context.scaling.size());
    ++context.budget.starts;
    numerics::LeastSquaresResult descent =
        solve_levenberg_marquardt(equations, from, 100, [&] { return context.budget.is_spent(); });
    if (descent.max_residual < condition_tolerance && is_exact(context, equations, descent.u) &&
        is_new_solution(result.solutions, descent.u)) {
      const bool usable = !options.is_usable || options.is_usable(descent.u);
      if (usable) {
        result.solutions.push_back(descent.u);
        ++context.budget.solutions;
        stalled_starts = 0;
      } else if (result.rejected.size() < max_rejected_solutions) {
        result.rejected.push_back(descent.u);
      }
    }
    if (k == 0 || (descent.values.size() > 0 && (result.closest.values.size() == 0 ||
                                                 descent.values.squaredNorm() < result.closest.values.squaredNorm())))
      result.closest = std::move(descent);
  }
  return result;
}

VectorX refine_solution(const NonlinearSystem& equations, const VectorX& u,
                        const std::function<VectorX(const VectorX&)>& exact_residual) {
  VectorX best = solve_levenberg_marquardt(equations, u).u;
  if (!exact_residual || equations.primary_rows == 0) return best;
  // The polynomials are accurate to about 1e-14 of the widest bounds; the last digits come from the mechanism itself.
  VectorX values, residual = exact_residual(best);
  MatrixX jacobian;
  for (int k = 0; k < 2 && numerics::max_abs(residual) > 1e-16; ++k) {
    if (!equations.evaluate(best, values, &jacobian)) break;
    const auto n = best.size();
    MatrixX a(equations.primary_rows + n, n);
    a << jacobian.topRows(equations.primary_rows),
        1e-9 * std::max(numerics::max_abs(jacobian), 1e-30) * MatrixX::Identity(n, n);
    VectorX b = VectorX::Zero(a.rows()), d = VectorX::Zero(n);
    b.head(equations.primary_rows) = -residual;
    numerics::bounded_least_squares(a, b, (-1.0 - best.array()).matrix(), (1.0 - best.array()).matrix(), d);
    const VectorX next = clip_to_unit_box(best + d), after = exact_residual(next);
    if (!(after.norm() < residual.norm())) break;
    best = next;
    residual = after;
  }
  return best;
}

MatrixX tangent_space(const NonlinearSystem& equations, const VectorX& u) {
  const auto n = u.size();
  if (equations.primary_rows == 0) return MatrixX::Identity(n, n);
  VectorX values;
  MatrixX jacobian;
  if (!equations.evaluate(u, values, &jacobian)) return MatrixX(n, 0);
  numerics::ColumnPivotingQr qr(jacobian.topRows(equations.primary_rows).transpose());
  qr.setThreshold(1e-9);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(n, n);
  return q.rightCols(n - qr.rank());
}

VectorX snap_to_special_values(const SolverContext& context, const NonlinearSystem& equations,
                               const std::function<double(const VectorX&)>& objective, VectorX u) {
  VectorX values;
  if (!equations.evaluate(u, values, nullptr)) return u;
  double residual = max_condition_residual(equations, values), objective_value = objective ? objective(u) : 0;
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double zero =
        context.scaling.half_width()[i] > 0 ? -context.scaling.centre()[i] / context.scaling.half_width()[i] : 0;
    for (const double target : {context.scaling.start()[i], -1.0, 1.0, zero}) {
      if (u[i] == target || !(std::abs(u[i] - target) < rounding_tolerance) || std::abs(target) > 1) continue;
      VectorX moved = u;
      moved[i] = target;
      if (!equations.evaluate(moved, values, nullptr) ||
          max_condition_residual(equations, values) > std::max(residual, residual_epsilon))
        continue;
      const double moved_objective = objective ? objective(moved) : 0;
      if (!(moved_objective <= objective_value + 1e-12 * std::abs(objective_value)) || !context.is_admissible(moved))
        continue;
      u = moved;
      residual = max_condition_residual(equations, values);
      objective_value = moved_objective;
      break;
    }
  }
  return u;
}

std::optional<VectorX> find_nearest_solution(const SolverContext& context, const LinearConditions& conditions) {
  const auto n = context.scaling.size();
  if (n == 0) return std::nullopt;
  numerics::QuadraticProgram program;
  program.hessian = MatrixX::Identity(n, n);
  program.gradient = -context.scaling.start();
  program.equalities = conditions.matrix;
  program.equality_values = conditions.rhs;
  program.inequalities.resize(2 * n, n);
  program.inequalities << MatrixX::Identity(n, n), -MatrixX::Identity(n, n);
  program.inequality_lower_bounds = VectorX::Constant(2 * n, -1);
  // Outer approximation: adds tangents of the concave inequalities that are violated.
  for (int cut = 0; cut < 50; ++cut) {
    const auto optimum = solve_quadratic_program(program);
    if (!optimum) return std::nullopt;
    VectorX u = clip_to_unit_box(optimum->x), g;
    for (double& value : u)
      if (std::abs(value) > 1 - 1e-12) value = value < 0 ? -1 : 1;
    if (context.inequality_count() == 0) return u;
    MatrixX dg;
    context.evaluate_inequalities(u, g, &dg);
    if (numerics::min_coefficient(g) >= -1e-9) return u;
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (g[k] >= -1e-9) continue;
      const auto rows = program.inequalities.rows();
      program.inequalities.conservativeResize(rows + 1, Eigen::NoChange);
      program.inequalities.row(rows) = dg.row(k);
      program.inequality_lower_bounds.conservativeResize(rows + 1);
      program.inequality_lower_bounds[rows] = dg.row(k).dot(u) - g[k];
    }
  }
  return std::nullopt;
}

}  // namespace balance::design
