#include "balance/design/equations.hpp"

#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance::design {

namespace {

/// Weight of a violated inequality among scaled residuals.
constexpr double violation_weight = 1;

/// Fills rows that are zero where g ≥ 0 and g elsewhere.
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

/// What is left of the conditions at a geometry, free of the choice of pivots: the parameters' projection on the row space, in
/// units that make parameters of different dimension comparable.
bool project_on_row_space(const SolverContext& context, const Mechanism& mechanism, const VectorX& unit,
                          VectorX& residual) {
  const Conditions conditions = context.derive_conditions(mechanism);
  if (conditions.status != ConditionsStatus::done) return false;
  const VectorX parameters = term_values(mechanism, context.options.loose_springs).cwiseQuotient(unit);
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
  const VariableClassification& survey = context_.classification;
  const VectorX &before = survey.base_features, &after = survey.perturbed_features[static_cast<std::size_t>(variable)];
  const double size = matrix_.row(row).cwiseAbs().dot(before.cwiseAbs().cwiseMax(after.cwiseAbs()));
  return std::abs(matrix_.row(row).dot(after - before)) > survey.change_threshold * size;
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
                                              std::vector<int> which, VectorX target) {
  NonlinearSystem equations;
  equations.primary_rows = static_cast<int>(which.size());
  equations.row_count = equations.primary_rows + context.inequality_count();
  equations.evaluate = [&context, &rows, which = std::move(which), target = std::move(target),
                        total = equations.row_count](const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX all;
    MatrixX slopes;
    rows.evaluate(u, all, jacobian != nullptr ? &slopes : nullptr);
    values.resize(total);
    values.head(target.size()) = all(which) - target;
    if (jacobian != nullptr) {
      jacobian->resize(total, u.size());
      jacobian->topRows(target.size()) = slopes(which, Eigen::all);
    }
    if (context.inequality_count() > 0) append_violations(context, u, target.size(), values, jacobian);
    return values.allFinite();
  };
  return equations;
}

NonlinearSystem make_geometry_equations(const SolverContext& context, const VectorX& from) {
  const Mechanism start = context.mechanism(from);
  using Residual = std::function<bool(const VectorX&, VectorX&)>;
  Residual residual;
  if (context.problem.is_modular) {
    residual = [&context, unit = parameter_scales(start, context.options.loose_springs)](const VectorX& u, VectorX& r) {
      return project_on_row_space(context, context.mechanism(u), unit, r);
    };
  } else {
    // shared because a std::function must be copyable; there is one owner in fact
    auto goal = std::make_shared<GoalResidual>(start, context.problem.goals, context.options);
    residual = [&context, goal](const VectorX& u, VectorX& r) { return goal->evaluate(context.mechanism(u), r); };
  }
  const auto safe = [&context, residual](const VectorX& u, VectorX& r) {
    try {
      return !context.budget.is_past_deadline() && residual(u, r) && r.allFinite();
    } catch (const SpecError&) {
      return false;  // an expression of the spec has no value here
    }
  };
  VectorX first;
  NonlinearSystem equations;
  equations.primary_rows = safe(from, first) ? static_cast<int>(first.size()) : 0;
  equations.row_count = equations.primary_rows + context.inequality_count();
  equations.evaluate = [&context, safe, count = equations.primary_rows, total = equations.row_count](
                           const VectorX& u, VectorX& values, MatrixX* jacobian) {
    constexpr double geometry_difference_step = 1e-7;  // Gauss–Newton then gains seven digits per step at the end
    VectorX r, ahead;
    if (!safe(u, r) || r.size() != count) return false;
    values.resize(total);
    values.head(count) = r;
    if (jacobian != nullptr) jacobian->resize(total, u.size());
    for (Eigen::Index i = 0; jacobian != nullptr && i < u.size(); ++i) {
      VectorX v = u;
      v[i] += u[i] > 0 ? -geometry_difference_step : geometry_difference_step;
      if (!safe(v, ahead) || ahead.size() != count) return false;
      jacobian->col(i).head(count) = (ahead - r) / (v[i] - u[i]);
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
    // the mechanism has no configuration to ask at
  }
  return otherwise;
}

double max_condition_residual(const NonlinearSystem& equations, const VectorX& values) {
  return equations.primary_rows > 0 ? max_abs(values.head(equations.primary_rows)) : 0;
}

}  // namespace balance::design
