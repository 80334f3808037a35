#include "balance/design/findings.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/conditions/naming.hpp"
#include "balance/conditions/text.hpp"
#include "balance/design/squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// A row that leaves the row space by this part of its size is another condition.
constexpr double row_space_tolerance = 1e-8;

/// Rows in units of their terms' sizes, so that they can be compared as vectors.
MatrixX scale_columns(const Conditions& conditions, const VectorX& unit) {
  return conditions.matrix * unit.asDiagonal();
}

/// Whether a change of geometry changes condition k.
std::vector<bool> find_changed_rows(const MatrixX& rows, const MatrixX& others) {
  std::vector<bool> changed(static_cast<std::size_t>(rows.rows()), others.rows() == 0);
  if (others.rows() == 0) return changed;
  const Eigen::HouseholderQR<MatrixX> qr(others.transpose());
  const MatrixX q = qr.householderQ() * MatrixX::Identity(others.cols(), others.rows());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const VectorX row = rows.row(k).transpose();
    changed[static_cast<std::size_t>(k)] = (row - q * (q.transpose() * row)).norm() > row_space_tolerance * row.norm();
  }
  return changed;
}

/// Numbers that change conditions through the geometry.
std::vector<std::vector<bool>> find_geometric_dependence(const SolverContext& context, const Conditions& conditions,
                                                         const VectorX& u) {
  const VectorX unit = parameter_scales(context.mechanism(u), context.options.loose_springs);
  const MatrixX rows = scale_columns(conditions, unit);
  std::vector<std::vector<bool>> result;
  for (int i = 0; i < context.scaling.size(); ++i) {
    std::vector<bool> changed(static_cast<std::size_t>(rows.rows()), false);
    if (context.classification.is_geometric[static_cast<std::size_t>(i)]) {
      VectorX v = u;
      v[i] += u[i] > 0 ? -0.05 : 0.05;
      const Conditions other = context.conditions_at(v);
      // where nothing can be derived, nothing is known to stay as it is
      changed = other.status == ConditionsStatus::done ? find_changed_rows(rows, scale_columns(other, unit))
                                                       : std::vector<bool>(changed.size(), true);
    }
    result.push_back(std::move(changed));
  }
  return result;
}

BoundedParameters bound_parameters(const SolverContext& context, const SparsePolynomial& in_numbers, int parameters) {
  BoundedParameters result;
  const auto& terms = in_numbers.terms();
  const auto count = static_cast<Eigen::Index>(terms.size());
  result.constant.setZero(parameters);
  result.gradient.setZero(parameters, count);
  result.lower.setZero(count);
  result.upper.setZero(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    const auto& term = terms[static_cast<std::size_t>(t)];
    double low = 1, high = 1;
    for (const auto& [variable, power] : term.monomial) {
      const double a = elementary::pow(context.scaling.lower()[variable], power),
                   b = elementary::pow(context.scaling.upper()[variable], power);
      const bool through_zero =
          power % 2 == 0 && context.scaling.lower()[variable] < 0 && context.scaling.upper()[variable] > 0;
      const double least = through_zero ? 0 : std::min(a, b), max_listed_conditions = std::max(a, b);
      const auto [smallest, largest] =
          std::minmax({low * least, low * max_listed_conditions, high * least, high * max_listed_conditions});
      low = smallest;
      high = largest;
    }
    result.lower[t] = low;
    result.upper[t] = high;
    for (const auto& [output, coefficient] : term.coefficients)
      if (output < parameters) result.gradient(output, t) = coefficient;
  }
  return result;
}

std::string format_conditions(const Conditions& conditions, int row) { return condition_text(conditions, row); }

/// The first few conditions of a list.
std::string format_conditions(const Conditions& conditions, const std::vector<int>& rows) {
  constexpr std::size_t max_listed_conditions = 3;
  std::string text;
  for (std::size_t k = 0; k < std::min(rows.size(), max_listed_conditions); ++k)
    text += (k == 0 ? "" : "; ") + format_conditions(conditions, rows[k]);
  if (rows.size() > max_listed_conditions) text += fmt::format("; and {} more", rows.size() - max_listed_conditions);
  return text;
}

/// The known terms that stand in conditions: "R1.viscous, push.m".
std::string list_known_term_names(const Conditions& conditions, const std::vector<int>& rows) {
  std::string names;
  for (Eigen::Index column = conditions.parameter_columns(); column < conditions.matrix.cols(); ++column)
    if (std::any_of(rows.begin(), rows.end(), [&](int row) { return conditions.matrix(row, column) != 0; }))
      names += (names.empty() ? "" : ", ") + conditions.parameters[static_cast<std::size_t>(column)].name;
  return names;
}

/// What friction and loads ask for by themselves cannot be met anyway and says nothing about the rest.
Conditions remove_known_rows(const Conditions& conditions) {
  Conditions own = conditions;
  const Eigen::Index rows = conditions.parameter_rows();
  own.rank = static_cast<int>(rows);
  own.matrix = conditions.matrix.topRows(rows);
  own.row_scales = conditions.row_scales.head(rows);
  own.pivots.resize(static_cast<std::size_t>(rows));
  return own;
}

std::string condition_count_text(std::size_t n) { return n == 1 ? "1 condition" : fmt::format("{} conditions", n); }

/// The least-squares residual itself combines the conditions to something that has a sign within the bounds, if they are
/// affine and the bounds alone are in the way.
std::optional<InfeasibilityCertificate> certify_by_residual(const Conditions& conditions, const ConditionResidual& rows,
                                                            const VectorX& residual) {
  if (!(rows.lower_bound(residual) > condition_tolerance * max_abs(residual))) return std::nullopt;
  InfeasibilityCertificate proof;
  proof.kind = InfeasibilityCertificate::Kind::bounds;
  proof.combination = residual.cwiseQuotient(conditions.row_scales);
  proof.coefficients = conditions.matrix.transpose() * proof.combination;
  const double largest = max_abs(proof.coefficients);
  proof.combination /= largest;
  proof.coefficients /= largest;
  proof.statement = linear_combination_text(conditions.parameters, proof.coefficients) +
                    " = 0 cannot hold: it is positive for all values within the bounds";
  return proof;
}

}  // namespace

std::vector<std::vector<int>> find_condition_variables(const SolverContext& context, const Conditions& conditions,
                                                       const VectorX& u) {
  const ConditionResidual rows(context, conditions);
  const auto changes = find_geometric_dependence(context, conditions, u);
  std::vector<std::vector<int>> result(static_cast<std::size_t>(rows.size()));
  for (int k = 0; k < rows.size(); ++k)
    for (int i = 0; i < context.scaling.size(); ++i)
      if (rows.has_variable(k, i) || changes[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)])
        result[static_cast<std::size_t>(k)].push_back(i);
  return result;
}

std::optional<InfeasibilityCertificate> find_infeasibility_certificate(const SolverContext& context,
                                                                       const Conditions& conditions,
                                                                       const ConditionResidual& rows,
                                                                       const VectorX& residual) {
  const Conditions own = remove_known_rows(conditions);
  if (auto proof = certify_infeasible(own, context.classification.base_mechanism)) return proof;
  if (!context.features.polynomial()) return std::nullopt;
  const auto parameters = static_cast<int>(conditions.matrix.cols());
  const SparsePolynomial in_numbers =
      context.features.polynomial()->substitute(context.scaling.centre(), context.scaling.half_width());
  if (auto proof = certify_infeasible(own, bound_parameters(context, in_numbers, parameters))) return proof;
  VectorX left = residual;
  left.tail(left.size() - own.matrix.rows()).setZero();
  if (auto proof = certify_by_residual(conditions, rows, left)) return proof;
  return certify_by_product_relaxation(context, own, in_numbers);
}

void determine_status(DesignOutcome& outcome) {
  const auto total = static_cast<std::size_t>(outcome.residuals_after.size());
  outcome.unmet_conditions.clear();
  for (Eigen::Index k = 0; k < outcome.residuals_after.size(); ++k)
    if (!(std::abs(outcome.residuals_after[k]) < condition_tolerance))
      outcome.unmet_conditions.push_back(static_cast<int>(k));
  if (outcome.conditions.goals.empty() && total == 0) {
    outcome.status = DesignStatus::no_goal;
    outcome.reason = "there is no goal: nothing is to be balanced";
    return;
  }
  if (outcome.unmet_conditions.empty()) {
    outcome.status = DesignStatus::balanced;
    outcome.reason =
        total == 0 ? "there is nothing to balance: every mechanism of this geometry meets the goal"
        : outcome.method == DesignMethod::none
            ? condition_count_text(total) + (total == 1 ? " is" : " are") + " met, and no free number changes that"
            : condition_count_text(total) + (total == 1 ? " is met" : " are met");
    return;
  }
  // what occurs in a condition at one geometry says nothing of others
  const bool impossible =
      outcome.certificate || (!outcome.unmet_fixed_conditions.empty() && outcome.method != DesignMethod::geometric);
  outcome.status = impossible ? DesignStatus::infeasible : DesignStatus::compromise;
  const Eigen::Index own = outcome.conditions.parameter_rows();
  if (std::all_of(outcome.unmet_conditions.begin(), outcome.unmet_conditions.end(), [&](int k) { return k >= own; }) &&
      std::all_of(outcome.unmet_conditions.begin(), outcome.unmet_conditions.end(), [&](int k) {
        return std::find(outcome.unmet_fixed_conditions.begin(), outcome.unmet_fixed_conditions.end(), k) !=
               outcome.unmet_fixed_conditions.end();
      })) {
    outcome.reason = fmt::format("no mass and no spring balances {}{}",
                                 list_known_term_names(outcome.conditions, outcome.unmet_conditions),
                                 own == 0 ? ""
                                          : "; " + condition_count_text(static_cast<std::size_t>(own)) +
                                                (own == 1 ? " on masses is met" : " on masses are met"));
    outcome.certificate.reset();  // of what the sentence says
    return;
  }
  if (outcome.certificate)
    outcome.reason = outcome.certificate->statement;
  else if (!outcome.unmet_fixed_conditions.empty())
    outcome.reason = fmt::format("no free number occurs in {}, which {} not met",
                                 format_conditions(outcome.conditions, outcome.unmet_fixed_conditions),
                                 outcome.unmet_fixed_conditions.size() == 1 ? "is" : "are");
  else
    outcome.reason = fmt::format(
        "no numbers within the bounds were found that meet all conditions (not proved impossible); {} of {} "
        "stay open: {}",
        outcome.unmet_conditions.size(), total, format_conditions(outcome.conditions, outcome.unmet_conditions));
}

}  // namespace balance::design
