#include "balance/design/equations.hpp"

#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance::designing {

namespace {

/// Weight of a violated inequality among scaled residuals.
constexpr double inequality_weight = 1;

/// Fills rows that are zero where g ≥ 0 and g elsewhere.
void append_inequalities(const Context& context, const VectorX& u, Eigen::Index first, VectorX& values,
                         MatrixX* jacobian) {
  VectorX g;
  MatrixX dg;
  context.evaluate_inequalities(u, g, jacobian != nullptr ? &dg : nullptr);
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    values[first + k] = inequality_weight * std::min(0.0, g[k]);
    if (jacobian == nullptr) continue;
    if (g[k] < 0)
      jacobian->row(first + k) = inequality_weight * dg.row(k);
    else
      jacobian->row(first + k).setZero();
  }
}

/// What is left of the conditions at a geometry, free of the choice of pivots: the parameters' projection on the row space, in
/// units that make parameters of different dimension comparable.
bool projected_residual(const Context& context, const Mechanism& mechanism, const VectorX& unit, VectorX& residual) {
  const Conditions conditions = context.derive(mechanism);
  if (conditions.status != ConditionsStatus::done) return false;
  const VectorX parameters = term_values(mechanism, context.options.loose_springs).cwiseQuotient(unit);
  residual.setZero(parameters.size());
  if (conditions.own_rows() == 0) return true;
  const MatrixX columns = (conditions.matrix.topRows(conditions.own_rows()) * unit.asDiagonal()).transpose();
  const Eigen::HouseholderQR<MatrixX> qr(columns);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(columns.rows(), columns.cols());
  residual = q * (q.transpose() * parameters);
  return true;
}

}  // namespace

FixedRows::FixedRows(const Context& context, const Conditions& conditions) : context_(context) {
  matrix_.setZero(conditions.matrix.rows(), context.map.features());
  for (Eigen::Index k = 0; k < matrix_.rows(); ++k)
    matrix_.row(k).head(conditions.matrix.cols()) = conditions.matrix.row(k) / conditions.scale[k];
  if (context.map.polynomial()) polynomial_ = context.map.polynomial()->combined(matrix_);
}

bool FixedRows::touches(int row, int variable) const {
  if (polynomial_) return polynomial_->touches(row, variable);
  const Survey& survey = context_.survey;
  const VectorX &before = survey.base_features, &after = survey.features[static_cast<std::size_t>(variable)];
  const double size = matrix_.row(row).cwiseAbs().dot(before.cwiseAbs().cwiseMax(after.cwiseAbs()));
  return std::abs(matrix_.row(row).dot(after - before)) > survey.disturbed * size;
}

bool FixedRows::affine(const std::vector<int>& rows) const {
  return polynomial_ && std::all_of(rows.begin(), rows.end(), [&](int row) { return polynomial_->affine(row); });
}

void FixedRows::evaluate(const VectorX& u, VectorX& residual, MatrixX* jacobian) const {
  if (polynomial_) {
    polynomial_->evaluate(u, residual, jacobian);
    return;
  }
  VectorX values;
  MatrixX slopes;
  context_.map.evaluate(u, values, jacobian != nullptr ? &slopes : nullptr);
  residual = matrix_ * values;
  if (jacobian != nullptr) *jacobian = matrix_ * slopes;
}

VectorX FixedRows::exact(const VectorX& u) const { return matrix_ * context_.map.exact(u); }

double FixedRows::least(const VectorX& factors) const {
  if (!polynomial_) return -std::numeric_limits<double>::infinity();
  return polynomial_->combined(factors.transpose()).least(0);
}

Equations fixed_equations(const Context& context, const FixedRows& rows, std::vector<int> which, VectorX target) {
  Equations equations;
  equations.conditions = static_cast<int>(which.size());
  equations.rows = equations.conditions + context.inequalities();
  equations.evaluate = [&context, &rows, which = std::move(which), target = std::move(target), total = equations.rows](
                           const VectorX& u, VectorX& values, MatrixX* jacobian) {
    VectorX all;
    MatrixX slopes;
    rows.evaluate(u, all, jacobian != nullptr ? &slopes : nullptr);
    values.resize(total);
    values.head(target.size()) = all(which) - target;
    if (jacobian != nullptr) {
      jacobian->resize(total, u.size());
      jacobian->topRows(target.size()) = slopes(which, Eigen::all);
    }
    if (context.inequalities() > 0) append_inequalities(context, u, target.size(), values, jacobian);
    return values.allFinite();
  };
  return equations;
}

Equations geometric_equations(const Context& context, const VectorX& from) {
  const Mechanism start = context.mechanism(from);
  using Residual = std::function<bool(const VectorX&, VectorX&)>;
  Residual residual;
  if (context.problem.modular) {
    residual = [&context, unit = parameter_units(start, context.options.loose_springs)](const VectorX& u, VectorX& r) {
      return projected_residual(context, context.mechanism(u), unit, r);
    };
  } else {
    // shared because a std::function must be copyable; there is one owner in fact
    auto goal = std::make_shared<GoalResidual>(start, context.problem.goals, context.options);
    residual = [&context, goal](const VectorX& u, VectorX& r) { return goal->evaluate(context.mechanism(u), r); };
  }
  const auto safe = [&context, residual](const VectorX& u, VectorX& r) {
    try {
      return !context.budget.over() && residual(u, r) && r.allFinite();
    } catch (const SpecError&) {
      return false;  // an expression of the spec has no value here
    }
  };
  VectorX first;
  Equations equations;
  equations.conditions = safe(from, first) ? static_cast<int>(first.size()) : 0;
  equations.rows = equations.conditions + context.inequalities();
  equations.evaluate = [&context, safe, count = equations.conditions, total = equations.rows](
                           const VectorX& u, VectorX& values, MatrixX* jacobian) {
    constexpr double step = 1e-7;  // Gauss–Newton then gains seven digits per step at the end
    VectorX r, ahead;
    if (!safe(u, r) || r.size() != count) return false;
    values.resize(total);
    values.head(count) = r;
    if (jacobian != nullptr) jacobian->resize(total, u.size());
    for (Eigen::Index i = 0; jacobian != nullptr && i < u.size(); ++i) {
      VectorX v = u;
      v[i] += u[i] > 0 ? -step : step;
      if (!safe(v, ahead) || ahead.size() != count) return false;
      jacobian->col(i).head(count) = (ahead - r) / (v[i] - u[i]);
    }
    if (context.inequalities() > 0) append_inequalities(context, u, count, values, jacobian);
    return values.allFinite() && (jacobian == nullptr || jacobian->allFinite());
  };
  return equations;
}

Equations equations_near(const Context& context, const VectorX& u, const Equations& otherwise) {
  if (otherwise.conditions == 0) return otherwise;
  try {
    Equations equations = geometric_equations(context, u);
    if (equations.conditions > 0) return equations;
  } catch (const SpecError&) {
    // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    // the mechanism has no configuration to ask at
  }
  return otherwise;
}

double worst(const Equations& equations, const VectorX& values) {
  return equations.conditions > 0 ? max_abs(values.head(equations.conditions)) : 0;
}

}  // namespace balance::designing
