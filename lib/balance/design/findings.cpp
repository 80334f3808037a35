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

namespace balance::designing {

namespace {

/// A row that leaves the row space by this part of its size is another condition.
constexpr double another = 1e-8;

/// Rows in units of their terms' sizes, so that they can be compared as vectors.
MatrixX comparable(const Conditions& conditions, const VectorX& unit) { return conditions.matrix * unit.asDiagonal(); }

/// Whether a change of geometry changes condition k.
std::vector<bool> changed_rows(const MatrixX& rows, const MatrixX& others) {
  std::vector<bool> changed(static_cast<std::size_t>(rows.rows()), others.rows() == 0);
  if (others.rows() == 0) return changed;
  const Eigen::HouseholderQR<MatrixX> qr(others.transpose());
  const MatrixX q = qr.householderQ() * MatrixX::Identity(others.cols(), others.rows());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const VectorX row = rows.row(k).transpose();
    changed[static_cast<std::size_t>(k)] = (row - q * (q.transpose() * row)).norm() > another * row.norm();
  }
  return changed;
}

/// Numbers that change conditions through the geometry.
std::vector<std::vector<bool>> geometric_changes(const Context& context, const Conditions& conditions,
                                                 const VectorX& u) {
  const VectorX unit = parameter_units(context.mechanism(u), context.options.loose_springs);
  const MatrixX rows = comparable(conditions, unit);
  std::vector<std::vector<bool>> result;
  for (int i = 0; i < context.box.size(); ++i) {
    std::vector<bool> changed(static_cast<std::size_t>(rows.rows()), false);
    if (context.survey.geometric[static_cast<std::size_t>(i)]) {
      VectorX v = u;
      v[i] += u[i] > 0 ? -0.05 : 0.05;
      const Conditions other = context.conditions_at(v);
      // where nothing can be derived, nothing is known to stay as it is
      changed = other.status == ConditionsStatus::done ? changed_rows(rows, comparable(other, unit))
                                                       : std::vector<bool>(changed.size(), true);
    }
    result.push_back(std::move(changed));
  }
  return result;
}

BoundedParameters bounded_parameters(const Context& context, const Polynomial& in_numbers, int parameters) {
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
      const double a = elementary::pow(context.box.lower()[variable], power),
                   b = elementary::pow(context.box.upper()[variable], power);
      const bool through_zero =
          power % 2 == 0 && context.box.lower()[variable] < 0 && context.box.upper()[variable] > 0;
      const double least = through_zero ? 0 : std::min(a, b), most = std::max(a, b);
      const auto [smallest, largest] = std::minmax({low * least, low * most, high * least, high * most});
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

std::string text_of(const Conditions& conditions, int row) { return condition_text(conditions, row); }

/// The first few conditions of a list.
std::string text_of(const Conditions& conditions, const std::vector<int>& rows) {
  constexpr std::size_t most = 3;
  std::string text;
  for (std::size_t k = 0; k < std::min(rows.size(), most); ++k)
    text += (k == 0 ? "" : "; ") + text_of(conditions, rows[k]);
  if (rows.size() > most) text += fmt::format("; and {} more", rows.size() - most);
  return text;
}

/// The known terms that stand in conditions: "R1.viscous, push.m".
std::string known_names(const Conditions& conditions, const std::vector<int>& rows) {
  std::string names;
  for (Eigen::Index column = conditions.own_columns(); column < conditions.matrix.cols(); ++column)
    if (std::any_of(rows.begin(), rows.end(), [&](int row) { return conditions.matrix(row, column) != 0; }))
      names += (names.empty() ? "" : ", ") + conditions.parameters[static_cast<std::size_t>(column)].name;
  return names;
}

/// What friction and loads ask for by themselves cannot be met anyway and says nothing about the rest.
Conditions without_known_rows(const Conditions& conditions) {
  Conditions own = conditions;
  const Eigen::Index rows = conditions.own_rows();
  own.rank = static_cast<int>(rows);
  own.matrix = conditions.matrix.topRows(rows);
  own.scale = conditions.scale.head(rows);
  own.pivots.resize(static_cast<std::size_t>(rows));
  return own;
}

std::string counted(std::size_t n) { return n == 1 ? "1 condition" : fmt::format("{} conditions", n); }

/// The least-squares residual itself combines the conditions to something that has a sign within the bounds, if they are
/// affine and the bounds alone are in the way.
std::optional<Impossibility> proof_by_residual(const Conditions& conditions, const FixedRows& rows,
                                               const VectorX& residual) {
  if (!(rows.least(residual) > met * max_abs(residual))) return std::nullopt;
  Impossibility proof;
  proof.kind = Impossibility::Kind::bounds;
  proof.combination = residual.cwiseQuotient(conditions.scale);
  proof.coefficients = conditions.matrix.transpose() * proof.combination;
  const double largest = max_abs(proof.coefficients);
  proof.combination /= largest;
  proof.coefficients /= largest;
  proof.sentence = linear_text(conditions.parameters, proof.coefficients) +
                   " = 0 cannot hold: it is positive for all values within the bounds";
  return proof;
}

}  // namespace

std::vector<std::vector<int>> find_occurring(const Context& context, const Conditions& conditions, const VectorX& u) {
  const FixedRows rows(context, conditions);
  const auto changes = geometric_changes(context, conditions, u);
  std::vector<std::vector<int>> result(static_cast<std::size_t>(rows.size()));
  for (int k = 0; k < rows.size(); ++k)
    for (int i = 0; i < context.box.size(); ++i)
      if (rows.touches(k, i) || changes[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)])
        result[static_cast<std::size_t>(k)].push_back(i);
  return result;
}

std::optional<Impossibility> find_proof(const Context& context, const Conditions& conditions, const FixedRows& rows,
                                        const VectorX& residual) {
  const Conditions own = without_known_rows(conditions);
  if (auto proof = prove_impossible(own, context.survey.at_base)) return proof;
  if (!context.map.polynomial()) return std::nullopt;
  const auto parameters = static_cast<int>(conditions.matrix.cols());
  const Polynomial in_numbers = context.map.polynomial()->substituted(context.box.centre(), context.box.half());
  if (auto proof = prove_impossible(own, bounded_parameters(context, in_numbers, parameters))) return proof;
  VectorX left = residual;
  left.tail(left.size() - own.matrix.rows()).setZero();
  if (auto proof = proof_by_residual(conditions, rows, left)) return proof;
  return prove_by_squares(context, own, in_numbers);
}

void conclude(DesignOutcome& outcome) {
  const auto total = static_cast<std::size_t>(outcome.after.size());
  outcome.open.clear();
  for (Eigen::Index k = 0; k < outcome.after.size(); ++k)
    if (!(std::abs(outcome.after[k]) < met)) outcome.open.push_back(static_cast<int>(k));
  if (outcome.conditions.goals.empty() && total == 0) {
    outcome.status = DesignStatus::not_asked;
    outcome.reason = "there is no goal: nothing is to be balanced";
    return;
  }
  if (outcome.open.empty()) {
    outcome.status = DesignStatus::balanced;
    outcome.reason = total == 0 ? "there is nothing to balance: every mechanism of this geometry meets the goal"
                     : outcome.method == DesignMethod::nothing_to_do
                         ? counted(total) + (total == 1 ? " is" : " are") + " met, and no free number changes that"
                         : counted(total) + (total == 1 ? " is met" : " are met");
    return;
  }
  // what occurs in a condition at one geometry says nothing of others
  const bool impossible = outcome.proof || (!outcome.unmet_fixed.empty() && outcome.method != DesignMethod::geometric);
  outcome.status = impossible ? DesignStatus::impossible : DesignStatus::compromise;
  const Eigen::Index own = outcome.conditions.own_rows();
  if (std::all_of(outcome.open.begin(), outcome.open.end(), [&](int k) { return k >= own; }) &&
      std::all_of(outcome.open.begin(), outcome.open.end(), [&](int k) {
        return std::find(outcome.unmet_fixed.begin(), outcome.unmet_fixed.end(), k) != outcome.unmet_fixed.end();
      })) {
    outcome.reason = fmt::format("no mass and no spring balances {}{}", known_names(outcome.conditions, outcome.open),
                                 own == 0 ? ""
                                          : "; " + counted(static_cast<std::size_t>(own)) +
                                                (own == 1 ? " on masses is met" : " on masses are met"));
    outcome.proof.reset();  // of what the sentence says
    return;
  }
  if (outcome.proof)
    outcome.reason = outcome.proof->sentence;
  else if (!outcome.unmet_fixed.empty())
    outcome.reason =
        fmt::format("no free number occurs in {}, which {} not met", text_of(outcome.conditions, outcome.unmet_fixed),
                    outcome.unmet_fixed.size() == 1 ? "is" : "are");
  else
    outcome.reason = fmt::format(
        "no numbers within the bounds were found that meet all conditions (not proved impossible); {} of {} "
        "stay open: {}",
        outcome.open.size(), total, text_of(outcome.conditions, outcome.open));
}

}  // namespace balance::designing
