#include "balance/synthesis/design/solution_analysis.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/design/feasible_directions.hpp"
#include "balance/synthesis/design/product_relaxation.hpp"
#include "balance/synthesis/design/tie_follower.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

/// A row with a component outside the row space of more than this fraction of its norm is another condition.
constexpr double row_space_tolerance = 1e-8;

/// Scales the columns by the units of their terms, so that rows can be compared as vectors.
MatrixX scale_columns(const Conditions& conditions, const VectorX& unit) {
  return conditions.matrix * unit.asDiagonal();
}

/// For each condition, whether a change of geometry changes it.
std::vector<bool> find_changed_rows(const MatrixX& rows, const MatrixX& other_rows) {
  std::vector<bool> changed(static_cast<std::size_t>(rows.rows()), other_rows.rows() == 0);
  if (other_rows.rows() == 0) return changed;
  const Eigen::HouseholderQR<MatrixX> qr(other_rows.transpose());
  const MatrixX q = qr.householderQ() * MatrixX::Identity(other_rows.cols(), other_rows.rows());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const VectorX row = rows.row(k).transpose();
    changed[static_cast<std::size_t>(k)] = (row - q * (q.transpose() * row)).norm() > row_space_tolerance * row.norm();
  }
  return changed;
}

/// For each variable, the conditions that it changes through the geometry.
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
      // If nothing can be derived, all conditions are assumed to change.
      changed = other.status == ConditionsStatus::done ? find_changed_rows(rows, scale_columns(other, unit))
                                                       : std::vector<bool>(changed.size(), true);
    }
    result.push_back(std::move(changed));
  }
  return result;
}

conditions::BoundedParameters bound_parameters(const SolverContext& context,
                                               const numerics::SparsePolynomial& in_numbers, int parameters) {
  conditions::BoundedParameters result;
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
      const double low_power = through_zero ? 0 : std::min(a, b), high_power = std::max(a, b);
      const auto [smallest, largest] =
          std::minmax({low * low_power, low * high_power, high * low_power, high * high_power});
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

/// The names of the known terms that occur in the conditions: "R1.viscous, push.m".
std::string list_known_term_names(const Conditions& conditions, const std::vector<int>& rows) {
  std::string names;
  for (Eigen::Index column = conditions.parameter_columns(); column < conditions.matrix.cols(); ++column)
    if (std::any_of(rows.begin(), rows.end(), [&](int row) { return conditions.matrix(row, column) != 0; }))
      names += (names.empty() ? "" : ", ") + conditions.parameters[static_cast<std::size_t>(column)].name;
  return names;
}

/// Removes the conditions on friction and loads alone: they cannot be met anyway and say nothing about the rest.
Conditions remove_known_rows(const Conditions& conditions) {
  Conditions parameter_conditions = conditions;
  const Eigen::Index rows = conditions.parameter_rows();
  parameter_conditions.rank = static_cast<int>(rows);
  parameter_conditions.matrix = conditions.matrix.topRows(rows);
  parameter_conditions.row_scales = conditions.row_scales.head(rows);
  parameter_conditions.pivots.resize(static_cast<std::size_t>(rows));
  return parameter_conditions;
}

std::string condition_count_text(std::size_t n) { return n == 1 ? "1 condition" : fmt::format("{} conditions", n); }

/// If the conditions are affine and only the bounds rule out a solution, the least-squares residual itself defines a
/// combination of the conditions whose sign is fixed within the bounds.
std::optional<conditions::InfeasibilityCertificate> certify_by_residual(const Conditions& conditions,
                                                                        const ConditionResidual& rows,
                                                                        const VectorX& residual) {
  if (!(rows.lower_bound(residual) > condition_tolerance * numerics::max_abs(residual))) return std::nullopt;
  conditions::InfeasibilityCertificate proof;
  proof.kind = conditions::InfeasibilityCertificate::Kind::bounds;
  proof.combination = residual.cwiseQuotient(conditions.row_scales);
  proof.coefficients = conditions.matrix.transpose() * proof.combination;
  const double largest = numerics::max_abs(proof.coefficients);
  proof.combination /= largest;
  proof.coefficients /= largest;
  proof.statement = conditions::linear_combination_text(conditions.parameters, proof.coefficients) +
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

std::optional<conditions::InfeasibilityCertificate> find_infeasibility_certificate(const SolverContext& context,
                                                                                   const Conditions& conditions,
                                                                                   const ConditionResidual& rows,
                                                                                   const VectorX& residual) {
  const Conditions parameter_conditions = remove_known_rows(conditions);
  if (auto proof = certify_infeasible(parameter_conditions, context.classification.base_mechanism)) return proof;
  if (!context.features.polynomial()) return std::nullopt;
  const auto parameters = static_cast<int>(conditions.matrix.cols());
  const numerics::SparsePolynomial in_numbers =
      context.features.polynomial()->substitute(context.scaling.centre(), context.scaling.half_width());
  if (auto proof = certify_infeasible(parameter_conditions, bound_parameters(context, in_numbers, parameters)))
    return proof;
  VectorX adjustable_residual = residual;
  adjustable_residual.tail(adjustable_residual.size() - parameter_conditions.matrix.rows()).setZero();
  if (auto proof = certify_by_residual(conditions, rows, adjustable_residual)) return proof;
  return certify_by_product_relaxation(context, parameter_conditions, in_numbers);
}

void determine_status(DesignOutcome& outcome) {
  const auto total = static_cast<std::size_t>(outcome.residuals_after.size());
  outcome.unmet_conditions.clear();
  for (Eigen::Index k = 0; k < outcome.residuals_after.size(); ++k)
    if (!(std::abs(outcome.residuals_after[k]) < condition_tolerance))
      outcome.unmet_conditions.push_back(static_cast<int>(k));
  if (outcome.conditions.goals.empty() && total == 0) {
    outcome.status = DesignStatus::no_goal;
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
  // The variables that occur in a condition at one geometry may not be those at another.
  const bool impossible =
      outcome.certificate || (!outcome.unmet_fixed_conditions.empty() && outcome.method != DesignMethod::geometric);
  outcome.status = impossible ? DesignStatus::infeasible : DesignStatus::compromise;
  const Eigen::Index parameter_rows = outcome.conditions.parameter_rows();
  if (std::all_of(outcome.unmet_conditions.begin(), outcome.unmet_conditions.end(),
                  [&](int k) { return k >= parameter_rows; }) &&
      std::all_of(outcome.unmet_conditions.begin(), outcome.unmet_conditions.end(), [&](int k) {
        return std::find(outcome.unmet_fixed_conditions.begin(), outcome.unmet_fixed_conditions.end(), k) !=
               outcome.unmet_fixed_conditions.end();
      })) {
    outcome.reason = fmt::format(
        "no mass or spring balances {}{}", list_known_term_names(outcome.conditions, outcome.unmet_conditions),
        parameter_rows == 0 ? ""
                            : "; " + condition_count_text(static_cast<std::size_t>(parameter_rows)) +
                                  (parameter_rows == 1 ? " on masses is met" : " on masses are met"));
    outcome.certificate.reset();  // the reason already says so
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
        "no numbers within the bounds were found that meet all conditions (not proved impossible); {} of {} are not "
        "met: {}",
        outcome.unmet_conditions.size(), total, format_conditions(outcome.conditions, outcome.unmet_conditions));
}

namespace {

std::vector<int> list_moving_variables(const MatrixX& basis) {
  std::vector<int> numbers;
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    if (basis.cols() > 0 && basis.row(i).norm() > null_space_tolerance) numbers.push_back(static_cast<int>(i));
  return numbers;
}

}  // namespace

FigureFace::FigureFace(const SolverContext& context, const VectorX& u, std::vector<AffineFigure> figures)
    : context_(context), figures_(std::move(figures)) {
  MatrixX slopes;
  context_.features.evaluate(u, parameters_, &slopes);
  constant_rows_ = find_constant_rows(slopes);
}

std::optional<FigureFace> FigureFace::make(const SolverContext& context, const VectorX& u) {
  if (!context.problem.model->capabilities().has_affine_terms) return std::nullopt;
  auto figures = context.convex_terms(u, FigureSampling::full);
  if (!figures) return std::nullopt;
  return FigureFace(context, u, std::move(*figures));
}

namespace {

/// Samples of a peak within this fraction of it count as reaching it.
constexpr double peak_tie_tolerance = 1e-7;

/// The samples of a series: components × samples.
MatrixX sample_values(const AffineSeries& series, const VectorX& features) {
  const Eigen::Index p = series.rows.cols() - 1;
  const VectorX values = series.rows.leftCols(p) * features.head(p) + series.rows.col(p);
  return values.reshaped(series.components, series.time_weights.size());
}

/// What a peak or a maximum is taken of, sample by sample.
VectorX sample_sizes(const AffineFigure& figure, const MatrixX& values) {
  if (figure.figure == Statistic::maximum) return values.row(0).transpose();
  return values.colwise().norm().transpose();
}

/// Whether a figure is that of its largest samples.
bool is_of_largest_samples(const AffineFigure& figure) {
  return figure.figure == Statistic::peak || figure.figure == Statistic::maximum;
}

double series_value(const AffineFigure& figure, const AffineSeries& series, const VectorX& features) {
  const MatrixX values = sample_values(series, features);
  if (figure.figure != Statistic::rms) return numerics::max_coefficient(sample_sizes(figure, values));
  return std::sqrt(values.colwise().squaredNorm().dot(series.time_weights.transpose()));
}

double worst_value(const AffineFigure& figure, const VectorX& features) {
  double worst = -std::numeric_limits<double>::infinity();
  for (const AffineSeries& series : figure.series) worst = std::max(worst, series_value(figure, series, features));
  return worst;
}

/// The triangle of a QR factorisation, which has the same null space and the same norm.
MatrixX compress(const MatrixX& rows) {
  if (rows.rows() <= rows.cols()) return rows;
  const Eigen::HouseholderQR<MatrixX> qr(rows);
  return qr.matrixQR().topRows(rows.cols()).triangularView<Eigen::Upper>();
}

MatrixX stack(const std::vector<MatrixX>& blocks, Eigen::Index columns) {
  Eigen::Index rows = 0;
  for (const MatrixX& block : blocks) rows += block.rows();
  MatrixX all(rows, columns);
  Eigen::Index first = 0;
  for (const MatrixX& block : blocks) {
    all.middleRows(first, block.rows()) = block;
    first += block.rows();
  }
  return all;
}

}  // namespace

bool FigureFace::is_complete() const {
  return figures_.size() == 1 && figures_.front().weight >= 0 &&
         (figures_.front().coefficients.size() > 0 || figures_.front().figure == Statistic::rms ||
          is_of_largest_samples(figures_.front()));
}

MatrixX FigureFace::find_constant_rows(const MatrixX& slopes) const {
  std::vector<MatrixX> blocks;
  VectorX linear;
  Eigen::Index parameter_count = 0;
  const auto add = [&](const AffineSeries& series, const MatrixX& rows) {
    parameter_count = rows.cols();
    const MatrixX all = series.rows.leftCols(rows.cols()) * slopes.topRows(rows.cols());
    // in units of the effect of all numbers, so that figures of different units can be compared
    if (const double size = all.norm(); size > 0) blocks.push_back(compress(rows) / size);
  };
  for (const AffineFigure& figure : figures_) {
    if (figure.weight == 0) continue;
    if (const Eigen::Index p = figure.coefficients.size(); p > 0) {
      if (linear.size() == 0) linear.setZero(p);
      parameter_count = p;
      linear += figure.weight * figure.coefficients;
      continue;
    }
    const bool has_worst_series = figure.figure == Statistic::rms || is_of_largest_samples(figure);
    const double worst = has_worst_series ? worst_value(figure, parameters_) : 0;
    for (const AffineSeries& series : figure.series) {
      const double threshold = worst - peak_tie_tolerance * std::abs(worst);
      if (has_worst_series && series_value(figure, series, parameters_) < threshold) continue;
      const MatrixX parameter_rows = series.rows.leftCols(series.rows.cols() - 1);
      if (!is_of_largest_samples(figure) || worst == 0) {
        add(series, parameter_rows);
        continue;
      }
      const VectorX sizes = sample_sizes(figure, sample_values(series, parameters_));
      std::vector<Eigen::Index> rows;
      for (Eigen::Index k = 0; k < sizes.size(); ++k)
        for (Eigen::Index c = 0; sizes[k] >= threshold && c < series.components; ++c)
          rows.push_back(k * series.components + c);
      add(series, parameter_rows(rows, Eigen::all));
    }
  }
  if (linear.size() > 0)
    if (const double size = (slopes.topRows(linear.size()).transpose() * linear).norm(); size > 0)
      blocks.emplace_back(linear.transpose() / size);
  return stack(blocks, parameter_count);
}

std::optional<std::vector<MaxTerm>> FigureFace::max_terms(const VectorX& u) const {
  VectorX features;
  MatrixX slopes;
  context_.features.evaluate(u, features, &slopes);
  std::vector<MaxTerm> terms;
  for (const AffineFigure& figure : figures_) {
    if (const Eigen::Index p = figure.coefficients.size(); p > 0) {
      terms.push_back({figure.weight, VectorX::Constant(1, figure.coefficients.dot(features.head(p))),
                       figure.coefficients.transpose() * slopes.topRows(p)});
      continue;
    }
    const bool is_range = figure.figure == Statistic::range;
    if (figure.figure == Statistic::minimum || (is_range && figure.series.size() != 1)) return std::nullopt;
    std::vector<MatrixX> values, by_number;
    for (const AffineSeries& series : figure.series) {
      const MatrixX samples = sample_values(series, features);
      const Eigen::Index p = series.rows.cols() - 1, count = samples.cols();
      const MatrixX rows = series.rows.leftCols(p) * slopes.topRows(p);
      VectorX sizes = samples.colwise().norm().transpose();
      const bool is_signed = is_range || figure.figure == Statistic::maximum;
      if (is_signed) sizes = samples.row(0).transpose();
      if (is_range && series.components != 1) return std::nullopt;
      MatrixX size_slopes(count, u.size());
      for (Eigen::Index k = 0; k < count; ++k) {
        const MatrixX own = rows.middleRows(k * series.components, series.components);
        if (is_signed)
          size_slopes.row(k) = own.row(0);
        else if (sizes[k] > 0)
          size_slopes.row(k) = samples.col(k).transpose() * own / sizes[k];
        else
          size_slopes.row(k).setZero();
      }
      if (is_range || is_of_largest_samples(figure)) {
        values.emplace_back(sizes);
        by_number.push_back(size_slopes);
        continue;
      }
      const VectorX weights = series.time_weights.reshaped();
      const double mean_square = weights.dot(sizes.cwiseAbs2()), rms = std::sqrt(mean_square);
      const bool is_rms = figure.figure == Statistic::rms;
      values.emplace_back(MatrixX::Constant(1, 1, is_rms ? rms : weights.dot(sizes)));
      const VectorX sample_weights = is_rms ? VectorX(weights.cwiseProduct(sizes) / std::max(rms, 1e-300)) : weights;
      by_number.emplace_back(sample_weights.transpose() * size_slopes);
    }
    const MatrixX all = stack(values, 1), all_slopes = stack(by_number, u.size());
    terms.push_back({figure.weight, all, all_slopes});
    if (is_range) terms.push_back({figure.weight, -all, -all_slopes});
  }
  return terms;
}

void FigureFace::evaluate_excess(const VectorX& features, const MatrixX* slopes, VectorX& excess,
                                 MatrixX* jacobian) const {
  std::vector<double> values;
  std::vector<VectorX> rows;
  for (const AffineFigure& figure : figures_) {
    if (!is_of_largest_samples(figure)) continue;
    const double limit = figure.series.empty() ? 0 : worst_value(figure, parameters_);
    if (!(std::abs(limit) > 0)) continue;
    for (const AffineSeries& series : figure.series) {
      const MatrixX samples = sample_values(series, features);
      const VectorX sizes = sample_sizes(figure, samples);
      for (Eigen::Index k = 0; k < sizes.size(); ++k) {
        const double over = (sizes[k] - limit) / std::abs(limit);
        values.push_back(std::max(0.0, over));
        if (jacobian == nullptr) continue;
        const MatrixX by_parameters =
            series.rows.block(k * series.components, 0, series.components, series.rows.cols() - 1);
        const MatrixX direction = figure.figure == Statistic::maximum
                                      ? MatrixX::Ones(1, 1)
                                      : MatrixX(samples.col(k).transpose() / std::max(sizes[k], 1e-300));
        rows.push_back(
            over > 0
                ? VectorX(
                      (direction * by_parameters * slopes->topRows(by_parameters.cols()) / std::abs(limit)).transpose())
                : VectorX::Zero(slopes->cols()));
      }
    }
  }
  excess = Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
  if (jacobian == nullptr) return;
  jacobian->resize(excess.size(), slopes->cols());
  for (std::size_t k = 0; k < rows.size(); ++k) jacobian->row(static_cast<Eigen::Index>(k)) = rows[k].transpose();
}

bool FigureFace::add_cuts(const VectorX& trial, const VectorX& centre, const MatrixX& basis,
                          numerics::LinearProgram& program) const {
  constexpr std::size_t max_cuts = 20;
  VectorX features;
  MatrixX slopes;
  context_.features.evaluate(trial, features, &slopes);
  bool has_cuts = false;
  for (const AffineFigure& figure : figures_) {
    if (!is_of_largest_samples(figure) || figure.series.empty()) continue;
    const double limit = worst_value(figure, parameters_);
    for (const AffineSeries& series : figure.series) {
      const MatrixX values = sample_values(series, features);
      const VectorX sizes = sample_sizes(figure, values);
      std::vector<Eigen::Index> exceeded;
      for (Eigen::Index k = 0; k < sizes.size(); ++k)
        if (sizes[k] > limit + 1e-11 * std::abs(limit)) exceeded.push_back(k);
      std::sort(exceeded.begin(), exceeded.end(), [&](Eigen::Index a, Eigen::Index b) { return sizes[a] > sizes[b]; });
      exceeded.resize(std::min(exceeded.size(), max_cuts));
      for (const Eigen::Index k : exceeded) {
        const MatrixX rows = series.rows.middleRows(k * series.components, series.components);
        const bool is_signed = figure.figure == Statistic::maximum;
        const MatrixX direction = is_signed ? MatrixX::Ones(1, 1) : MatrixX(values.col(k).transpose() / sizes[k]);
        const VectorX normal =
            (direction * rows.leftCols(rows.cols() - 1) * slopes.topRows(rows.cols() - 1)).transpose();
        const double scale = std::abs(sizes[k]);
        program.add_row(-numerics::no_bound, basis.transpose() * normal / scale,
                        (limit - sizes[k] + normal.dot(trial - centre)) / scale);
        has_cuts = true;
      }
    }
  }
  return has_cuts;
}

namespace {

/// Directions along which the objective has neither slope nor curvature.
MatrixX find_flat_directions(const ScaledObjective& objective, const MatrixX& basis, const VectorX& u) {
  VectorX slope;
  const double value = objective(u, &slope);
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
    objective(u + curvature_difference_step * flat.col(k), &ahead);
    objective(u - curvature_difference_step * flat.col(k), &behind);
    curvature.col(k) = flat.transpose() * (ahead - behind) / (2 * curvature_difference_step);
  }
  if (!curvature.allFinite()) return flat;
  const numerics::SymmetricEigenSolver solver((curvature + curvature.transpose()) / 2);
  std::vector<Eigen::Index> flat_columns;
  for (Eigen::Index k = 0; k < flat.cols(); ++k)
    if (std::abs(solver.eigenvalues()[k]) <= null_space_tolerance * size) flat_columns.push_back(k);
  return flat * solver.eigenvectors()(Eigen::all, flat_columns);
}

/// Unit vectors of the variables that may take any value between their bounds.
MatrixX continuous_directions(const SolverContext& context) {
  std::vector<Eigen::Index> numbers;
  for (int i = 0; i < context.scaling.size(); ++i)
    if (context.scaling.half_width()[i] > 0 &&
        context.problem.variables[static_cast<std::size_t>(i)].discrete_values.empty())
      numbers.push_back(i);
  return MatrixX::Identity(context.scaling.size(), context.scaling.size())(Eigen::all, numbers);
}

/// The conditions' derivatives at one geometry.
MatrixX mass_jacobian(const SolverContext& context, const Conditions& conditions, const VectorX& u) {
  if (conditions.matrix.rows() == 0) return MatrixX(0, u.size());
  VectorX residual;
  MatrixX jacobian;
  ConditionResidual(context, conditions).evaluate(u, residual, &jacobian);
  return jacobian;
}

/// The conditions' derivatives. @return false if they cannot be computed
bool compute_jacobian(const SolverContext& context, const Conditions& conditions, const VectorX& u, MatrixX& jacobian) {
  jacobian = mass_jacobian(context, conditions, u);
  if (jacobian.rows() == 0 || !context.classification.has_geometric()) return true;
  const numerics::NonlinearSystem equations = make_equations_near(context, u, {});
  VectorX values;
  if (!equations.evaluate || !equations.evaluate(u, values, &jacobian)) return false;
  jacobian.conservativeResize(equations.primary_rows, Eigen::NoChange);
  return true;
}

constexpr double precise_null_space_tolerance = 1e-9;

/// Directions within `free` along which the objective stays the same; std::nullopt if this is unknown.
/// @param limits normals of the active constraints
std::optional<MatrixX> find_optimal_directions(const SolverContext& context, const ScaledObjective& objective,
                                               const Conditions& conditions, const MatrixX& free, const MatrixX& limits,
                                               const VectorX& u) {
  std::vector<int> numbers;
  for (int i = 0; i < context.scaling.size(); ++i)
    if (!context.classification.is_geometric[static_cast<std::size_t>(i)]) numbers.push_back(i);
  const std::optional<FigureFace> face = FigureFace::make(context, u);
  MatrixX masses = find_flat_mass_directions(context, &objective, face ? &*face : nullptr, conditions, u, numbers);
  const bool is_complete =
      !context.classification.has_geometric() && (face ? face->is_complete() : !objective.is_simulated());
  if (is_complete || free.cols() == masses.cols()) return masses;
  // what is left: lengths, motions, and figures of which only values are known
  const TieFollower::Terms terms = [&](const VectorX& v) -> std::optional<std::vector<MaxTerm>> {
    if (face && !context.classification.has_geometric()) return face->max_terms(v);
    return objective.has_max_terms() ? objective.max_terms(v) : std::nullopt;
  };
  return TieFollower(context, objective, terms, conditions, u).find_directions(free, masses, limits);
}

}  // namespace

MatrixX find_flat_mass_directions(const SolverContext& context, const ScaledObjective* objective,
                                  const FigureFace* face, const Conditions& conditions, const VectorX& u,
                                  const std::vector<int>& numbers) {
  MatrixX basis = continuous_directions(context);
  std::vector<Eigen::Index> columns;
  for (Eigen::Index k = 0; k < basis.cols(); ++k)
    if (std::any_of(numbers.begin(), numbers.end(), [&](int i) { return basis(i, k) != 0; })) columns.push_back(k);
  basis = basis(Eigen::all, columns).eval();
  basis = restrict_to_null_space(basis, mass_jacobian(context, conditions, u), precise_null_space_tolerance);
  if (basis.cols() == 0 || objective == nullptr) return basis;
  if (face != nullptr) {
    VectorX features;
    MatrixX slopes;
    context.features.evaluate(u, features, &slopes);
    const MatrixX& rows = face->constant_parameter_rows();
    return restrict_to_null_space(basis, rows * slopes.topRows(rows.cols()), null_space_tolerance);
  }
  return objective->is_simulated() ? MatrixX(u.size(), 0) : find_flat_directions(*objective, basis, u);
}

namespace {

/// Whether a limit of zero is active: its figure has a kink there if it is a peak or an rms.
bool has_active_limit_at_zero(const SolverContext& context, const VectorX& u) {
  for (int k = 0; k < context.limits->size(); ++k)
    if (context.problem.limits[static_cast<std::size_t>(k)].bound == 0 &&
        std::abs(context.limits->value(u, k)) <= limit_tolerance)
      return true;
  return false;
}

}  // namespace

SolutionSet analyse_solution_set(const SolverContext& context, const ScaledObjective* objective,
                                 const Conditions& conditions, const VectorX& u) {
  SolutionSet solution_set;
  MatrixX jacobian;
  if (has_active_limit_at_zero(context, u)) return solution_set;
  if (!compute_jacobian(context, conditions, u, jacobian)) return solution_set;
  const MatrixX limits = active_constraint_normals(context, u);
  const MatrixX free = restrict_to_null_space(
      continuous_directions(context), jacobian,
      context.classification.has_geometric() ? null_space_tolerance : precise_null_space_tolerance);
  MatrixX directions = span_feasible_directions(free, limits);
  if (!context.problem.goals.empty()) {
    solution_set.dimension = static_cast<int>(directions.cols());
    solution_set.free_variables = list_moving_variables(directions);
  }
  if (objective == nullptr) {
    solution_set.optimal_dimension = solution_set.dimension;
    return solution_set;
  }
  const std::optional<MatrixX> optimal = find_optimal_directions(context, *objective, conditions, free, limits, u);
  if (!optimal) return solution_set;
  directions = span_feasible_directions(*optimal, limits);
  solution_set.optimal_dimension = static_cast<int>(directions.cols());
  solution_set.free_variables = list_moving_variables(directions);
  return solution_set;
}

namespace {

std::string summarise_search(const SearchBudget& budget, SearchTarget target) {
  std::vector<std::string> parts;
  if (budget.starts > 0) parts.push_back(count_noun(budget.starts, "start", "starts"));
  if (budget.solutions > 0 && target == SearchTarget::objective)
    parts.push_back(count_noun(budget.solutions, "exact design", "exact designs"));
  if (budget.geometries > 0) parts.push_back(count_noun(budget.geometries, "set of lengths", "sets of lengths"));
  if (budget.local_searches > 0) parts.push_back(count_noun(budget.local_searches, "local search", "local searches"));
  if (budget.evaluations > 0) parts.push_back(count_noun(budget.evaluations, "evaluation", "evaluations"));
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

SearchEffort make_search_effort(const SearchBudget& budget, SearchTarget target, bool proved) {
  using End = SearchEffort::Termination;
  SearchEffort effort{budget.starts,      budget.local_searches, budget.geometries,
                      budget.evaluations, budget.ends,           End::starts_exhausted};
  const bool has_searched = budget.starts + budget.local_searches + budget.geometries + budget.evaluations > 0;
  effort.termination = proved                            ? End::proved
                       : budget.stopped                  ? End::time_limit
                       : !has_searched                   ? End::not_searched
                       : target == SearchTarget::nothing ? End::goal_met
                                                         : End::starts_exhausted;
  return effort;
}

}  // namespace

void assess_optimality(const SolverContext& context, SearchTarget target, bool proved, DesignOutcome& outcome) {
  outcome.search_summary = summarise_search(context.budget, target);
  outcome.effort = make_search_effort(context.budget, target, proved);
  if (target == SearchTarget::nothing) {
    outcome.optimality = Optimality::not_optimised;
  } else if (proved) {
    outcome.optimality = Optimality::proved_global;
  } else if (context.budget.stopped) {
    outcome.optimality = Optimality::budget_exhausted;
  } else {
    outcome.optimality = Optimality::local_optimum;
  }
}

void raise_lower_bound(DesignOutcome& outcome, double lower_bound) {
  outcome.lower_bound = std::min(std::fmax(outcome.lower_bound, lower_bound), outcome.objective);
  if (outcome.gap() > relative_gap_tolerance * std::abs(outcome.objective)) return;
  outcome.optimality = Optimality::proved_global;
  outcome.effort.termination = SearchEffort::Termination::proved;
}

std::string undefined_objective_reason(const Objective& objective, const std::string& where,
                                       const std::string& failure_reason) {
  std::string reason = fmt::format("{} cannot be computed {}", objective.name, where);
  if (!failure_reason.empty()) reason += ": " + failure_reason;
  return reason;
}

std::string describe_worst_limit(const std::vector<DesignLimit>& limits, const std::vector<LimitOutcome>& outcomes) {
  std::size_t worst = 0;
  for (std::size_t k = 1; k < outcomes.size(); ++k)
    if (!(outcomes[k].violation <= outcomes[worst].violation)) worst = k;
  const DesignLimit& limit = limits[worst];
  const double violation = outcomes[worst].violation;
  if (!std::isfinite(violation)) return fmt::format("{} cannot be computed", limit.text);
  return limit.bound != 0 ? fmt::format("{} is missed by {:.3g} % of its bound", limit.text, 100 * violation)
                          : fmt::format("{} is missed by {:.3g}", limit.text, violation);
}

}  // namespace balance::design
