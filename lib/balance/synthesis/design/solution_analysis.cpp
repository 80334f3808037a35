#include "balance/synthesis/design/solution_analysis.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/design/product_relaxation.hpp"

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

namespace {

/// Numbers this near to a bound lie on it; physical limits likewise.
constexpr double active_bound_tolerance = 1e-9;
/// Directions that move a number less than this part of the whole do not move it.
constexpr double null_space_tolerance = 1e-6;

/// Orthonormal columns that span what the rows leave free within the span of `basis`.
MatrixX restrict_to_null_space(const MatrixX& basis, const MatrixX& rows, double tolerance) {
  if (basis.cols() == 0 || rows.rows() == 0) return basis;
  const MatrixX inside = rows * basis;
  const double size = rows.norm();
  if (!(size > 0)) return basis;
  const SingularValueDecomposition svd(inside, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > tolerance * size) ++rank;
  return basis * svd.matrixV().rightCols(basis.cols() - rank);
}

/// Rows that a direction must not make negative: bounds and physical limits that u lies on.
MatrixX active_constraint_normals(const SolverContext& context, const VectorX& u) {
  const auto n = u.size();
  std::vector<VectorX> rows;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (u[i] <= -1 + active_bound_tolerance) rows.push_back(VectorX::Unit(n, i));
    if (u[i] >= 1 - active_bound_tolerance) rows.push_back(-VectorX::Unit(n, i));
  }
  if (context.inequality_count() > 0) {
    VectorX g;
    MatrixX dg;
    context.evaluate_inequalities(u, g, &dg);
    for (Eigen::Index k = 0; k < g.size(); ++k)
      if (g[k] < active_bound_tolerance && dg.row(k).allFinite()) rows.push_back(dg.row(k).transpose());
  }
  MatrixX limits(static_cast<Eigen::Index>(rows.size()), n);
  for (std::size_t k = 0; k < rows.size(); ++k) limits.row(static_cast<Eigen::Index>(k)) = rows[k].transpose();
  return limits;
}

/// What the cone of directions within the span that keep all limits spans itself: limits that none of them leaves are equalities.
MatrixX span_feasible_directions(const MatrixX& basis, const MatrixX& limits) {
  const auto k = basis.cols(), m = limits.rows();
  if (k == 0 || m == 0) return basis;
  // as many limits as possible are left by 1: what stays at 0 can be left by no direction
  LinearProgram program(k + m);
  program.lower.tail(m).setZero();
  program.upper.tail(m).setOnes();
  program.cost.tail(m).setConstant(-1);
  const MatrixX inside = limits * basis;
  for (Eigen::Index row = 0; row < m; ++row) {
    VectorX coefficients = VectorX::Zero(k + m);
    const double size = inside.row(row).norm();
    if (size > null_space_tolerance * limits.row(row).norm()) coefficients.head(k) = inside.row(row).transpose() / size;
    coefficients[k + row] = -1;
    program.add_row(0, coefficients, no_bound);
  }
  const LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status != LinearProgramStatus::optimal) return basis;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index row = 0; row < m; ++row)
    if (solution.x[k + row] < 0.5) kept.push_back(row);
  return restrict_to_null_space(basis, limits(kept, Eigen::all), null_space_tolerance);
}

/// Directions in which the objective neither changes nor curves.
MatrixX find_flat_directions(const ScaledObjective& merit, const MatrixX& basis, const VectorX& u) {
  VectorX slope;
  const double value = merit(u, &slope);
  if (!std::isfinite(value) || !slope.allFinite() || basis.cols() == 0) return basis;
  const double size = std::max(std::abs(value), slope.norm());
  MatrixX flat = basis;
  if ((basis.transpose() * slope).norm() > null_space_tolerance * size)
    flat = restrict_to_null_space(basis, slope.transpose(), null_space_tolerance);
  if (flat.cols() == 0) return flat;
  constexpr double curvature_difference_step = 1e-3;
  MatrixX curvature(flat.cols(), flat.cols());
  for (Eigen::Index k = 0; k < flat.cols(); ++k) {
    VectorX ahead, behind;
    merit(u + curvature_difference_step * flat.col(k), &ahead);
    merit(u - curvature_difference_step * flat.col(k), &behind);
    curvature.col(k) = flat.transpose() * (ahead - behind) / (2 * curvature_difference_step);
  }
  if (!curvature.allFinite()) return flat;
  const SymmetricEigenSolver solver((curvature + curvature.transpose()) / 2);
  std::vector<Eigen::Index> straight;
  for (Eigen::Index k = 0; k < flat.cols(); ++k)
    if (std::abs(solver.eigenvalues()[k]) <= null_space_tolerance * size) straight.push_back(k);
  return flat * solver.eigenvectors()(Eigen::all, straight);
}

std::vector<int> list_moving_variables(const MatrixX& basis) {
  std::vector<int> numbers;
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    if (basis.cols() > 0 && basis.row(i).norm() > null_space_tolerance) numbers.push_back(static_cast<int>(i));
  return numbers;
}

}  // namespace

SolutionSet analyse_solution_set(const SolverContext& context, const NonlinearSystem& equations,
                                 const ScaledObjective* merit, const VectorX& u, bool precise) {
  SolutionSet freedom;
  const auto n = u.size();
  VectorX values;
  MatrixX jacobian(0, n);
  if (equations.primary_rows > 0 && !equations.evaluate(u, values, &jacobian)) return freedom;
  const MatrixX rows = jacobian.topRows(equations.primary_rows);
  const MatrixX limits = active_constraint_normals(context, u);
  const MatrixX free = restrict_to_null_space(MatrixX::Identity(n, n), rows, precise ? 1e-9 : null_space_tolerance);
  MatrixX directions = span_feasible_directions(free, limits);
  freedom.dimension = static_cast<int>(directions.cols());
  freedom.free_variables = list_moving_variables(directions);
  if (merit == nullptr) {
    freedom.optimal_dimension = freedom.dimension;
    return freedom;
  }
  if (merit->is_simulated() || !precise) return freedom;  // what the figure does along them is not known
  directions = span_feasible_directions(find_flat_directions(*merit, free, u), limits);
  freedom.optimal_dimension = static_cast<int>(directions.cols());
  freedom.free_variables = list_moving_variables(directions);
  return freedom;
}

namespace {

std::string summarise_search(const SearchBudget& budget, SearchTarget aim) {
  std::vector<std::string> parts;
  if (budget.starts > 0) parts.push_back(count_noun(budget.starts, "start", "starts"));
  if (budget.solutions > 0 && aim == SearchTarget::objective)
    parts.push_back(count_noun(budget.solutions, "exact design", "exact designs"));
  if (budget.geometries > 0) parts.push_back(count_noun(budget.geometries, "set of lengths", "sets of lengths"));
  if (budget.local_searches > 0)
    parts.push_back(
        count_noun(budget.local_searches, "local search", "local searches") +
        (budget.repeated_optima > 0 ? fmt::format(" ({} of them as good as the best)", budget.repeated_optima) : ""));
  if (budget.evaluations > 0) parts.push_back(count_noun(budget.evaluations, "evaluation", "evaluations"));
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

SearchEffort make_search_effort(const SearchBudget& budget, SearchTarget aim, bool proved) {
  using End = SearchEffort::Termination;
  SearchEffort effort{
      budget.starts,     budget.local_searches, budget.repeated_optima > 0 ? budget.repeated_optima : -1,
      budget.geometries, budget.evaluations,    End::starts_exhausted};
  const bool any = budget.starts + budget.local_searches + budget.geometries + budget.evaluations > 0;
  effort.termination = proved                         ? End::proved
                       : budget.stopped               ? End::time_limit
                       : !any                         ? End::not_searched
                       : aim == SearchTarget::nothing ? End::goal_met
                                                      : End::starts_exhausted;
  return effort;
}

}  // namespace

void assess_optimality(const SolverContext& context, SearchTarget aim, bool proved, DesignOutcome& outcome) {
  outcome.search_summary = summarise_search(context.budget, aim);
  outcome.effort = make_search_effort(context.budget, aim, proved);
  if (aim == SearchTarget::nothing) {
    outcome.optimality = Optimality::not_optimised;
  } else if (proved) {
    outcome.optimality = Optimality::proved_global;
  } else if (context.budget.stopped) {
    outcome.optimality = Optimality::budget_exhausted;
  } else {
    outcome.optimality = Optimality::local_optimum;
  }
}

std::string undefined_objective_reason(const Objective& objective, const std::string& where,
                                       const std::string& trouble) {
  std::string reason = fmt::format("{} cannot be computed {}", objective.name, where);
  if (!trouble.empty()) reason += ": " + trouble;
  return reason;
}

}  // namespace balance::design
