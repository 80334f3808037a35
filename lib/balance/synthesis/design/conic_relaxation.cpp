#include "balance/synthesis/design/conic_relaxation.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Penalty weights of rows and limits relative to a figure of size one. A penalty is exact unless a multiplier exceeds
/// its weight, and gives a bound in any case. Smaller weights preserve more digits.
constexpr double penalty_weights[] = {30, 1e3, 3e4};
/// Round-off of the rows of a program.
constexpr double row_tolerance = 1e-12;

std::vector<bool> find_active_parameters(const SolverContext& context, const MatrixX& rows,
                                         const std::vector<AffineFigure>& figures,
                                         const std::vector<ConvexLimit>& limits) {
  std::vector<bool> is_active_parameter(
      conditions::list_terms(context.classification.base_mechanism, context.options.loose_springs).size(), false);
  const double largest = numerics::max_abs(rows.colwise().norm());
  for (std::size_t k = 0; k < is_active_parameter.size() && rows.rows() > 0; ++k)
    is_active_parameter[k] = rows.col(static_cast<Eigen::Index>(k)).norm() > 1e-12 * largest;
  mark_active_parameters(figures, is_active_parameter);
  for (const ConvexLimit& limit : limits) mark_active_parameters(limit.figures, is_active_parameter);
  return is_active_parameter;
}

/// A program with some variables fixed.
struct PresolvedProgram {
  numerics::ConeProgram program;
  double constant = 0;  ///< cost of the fixed variables
  bool is_feasible = true;
  std::vector<Eigen::Index> free_variables;
};

class ConePresolve {
 public:
  ConePresolve(const numerics::ConeProgram& program, const std::vector<std::pair<Eigen::Index, double>>& fixed)
      : program_(program) {
    std::vector<bool> is_fixed(static_cast<std::size_t>(program.cost.size()), false);
    rhs_ = program.rhs;
    for (const auto& [k, value] : fixed) {
      is_fixed[static_cast<std::size_t>(k)] = true;
      rhs_ -= program.matrix.col(k) * value;
      result_.constant += program.cost[k] * value;
    }
    for (Eigen::Index k = 0; k < program.cost.size(); ++k)
      if (!is_fixed[static_cast<std::size_t>(k)]) result_.free_variables.push_back(k);
  }

  PresolvedProgram run() {
    columns_ = program_.matrix(Eigen::all, result_.free_variables);
    numerics::ConeProgramBuilder rows(columns_.cols());
    for (Eigen::Index i = 0; i < program_.linear_rows; ++i) {
      if (!columns_.row(i).isZero(0))
        rows.add_inequalities(VectorX(columns_.row(i).transpose()), rhs_[i]);
      else if (rhs_[i] < -row_tolerance * scale(i, 1))
        result_.is_feasible = false;
    }
    Eigen::Index row = program_.linear_rows;
    for (const Eigen::Index size : program_.cone_sizes) {
      add_cone(row, size, rows);
      row += size;
    }
    result_.program = rows.build(program_.cost(result_.free_variables));
    return std::move(result_);
  }

 private:
  double scale(Eigen::Index row, Eigen::Index count) const {
    return 1 + numerics::max_abs(program_.rhs.segment(row, count)) +
           numerics::max_abs(program_.matrix.middleRows(row, count));
  }
  void add_cone(Eigen::Index row, Eigen::Index size, numerics::ConeProgramBuilder& rows) {
    const VectorX constant = rhs_.segment(row, size);
    if (!columns_.middleRows(row, size).isZero(0))
      rows.add_cone(-columns_.middleRows(row, size), constant);
    else if (constant[0] < constant.tail(size - 1).norm() - 1e-9 * scale(row, size))
      result_.is_feasible = false;
  }

  const numerics::ConeProgram& program_;
  VectorX rhs_;
  MatrixX columns_;
  PresolvedProgram result_;
};

}  // namespace

ConicRelaxation::ConicRelaxation(const SolverContext& context, const MatrixX& rows,
                                 const std::vector<AffineFigure>& figures, const std::vector<ConvexLimit>& limits)
    : context_(context),
      model_(context, context.scaling.start(), find_active_parameters(context, rows, figures, limits)),
      has_figure_(!figures.empty()) {
  std::optional<AffineTerms> terms = model_.evaluate(context.scaling.start());
  has_terms_ = terms.has_value();
  if (!has_terms_) return;
  data_.terms = std::move(*terms);
  data_.rows = rows * data_.terms.matrix;
  data_.right = -rows * data_.terms.constant;
  VectorX middle = VectorX::Zero(data_.terms.matrix.cols() + 1), high = VectorX::Ones(middle.size());
  middle[middle.size() - 1] = 1;
  double middle_value = 0, upper_value = 0;
  for (const AffineFigure& figure : figures) {
    data_.figures.push_back({express_in_unknowns(figure, data_.terms)});
    middle_value += figure.weight * data_.figures.back().figure(middle);
    upper_value += figure.weight * data_.figures.back().figure(high);
  }
  figure_scale_ = std::max(std::abs(middle_value), 1e-3 * std::abs(upper_value));
  if (!(figure_scale_ > 0)) figure_scale_ = 1;
  for (InnerFigure& one : data_.figures) one.scale = figure_scale_;
  data_.limit_bounds.resize(static_cast<Eigen::Index>(limits.size()));
  for (std::size_t l = 0; l < limits.size(); ++l) {
    const double bound = limits[l].bound, scale = bound != 0 ? std::abs(bound) : figure_scale_;
    data_.limit_bounds[static_cast<Eigen::Index>(l)] = bound / scale;
    for (const AffineFigure& figure : limits[l].figures)
      data_.figures.push_back({express_in_unknowns(figure, data_.terms), scale, static_cast<int>(l)});
  }
}

/// Maximum violation of the limits and, with `rows`, of the rows.
double ConicRelaxation::max_violation(const VectorX& unknowns, bool rows) const {
  VectorX with_one(unknowns.size() + 1), violations = -data_.limit_bounds;
  with_one << unknowns, 1;
  for (const auto& [figure, scale, limit] : data_.figures)
    if (limit >= 0) violations[limit] += figure.weight / scale * figure(with_one);
  double worst = std::max(0.0, numerics::max_coefficient(violations));
  if (rows) worst = std::max(worst, (data_.rows * unknowns - data_.right).norm());
  return worst;
}

bool ConicRelaxation::is_complete() const {
  return has_terms_ && std::all_of(model_.outer().begin(), model_.outer().end(),
                                   [&](int i) { return context_.scaling.half_width()[i] == 0; });
}

/// The constraints begin with the bounds of the linear unknowns: first the upper, then the lower ones.
InnerData ConicRelaxation::restrict_data(const VariableDomain& domain, FixedUnknowns& fixed) const {
  InnerData data = data_;
  numerics::ConeProgram& limits = data.terms.constraints;
  const std::vector<int>& linear = model_.linear();
  const auto n = static_cast<Eigen::Index>(linear.size());
  const VariableScaling& scaling = context_.scaling;
  const auto unit = [&](int i, double value) {
    return scaling.half_width()[i] > 0 ? std::clamp((value - scaling.centre()[i]) / scaling.half_width()[i], -1.0, 1.0)
                                       : 0.0;
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const int i = linear[static_cast<std::size_t>(k)];
    limits.rhs[k] = unit(i, domain.upper[i]);
    limits.rhs[n + k] = -unit(i, domain.lower[i]);
    if (domain.lower[i] == domain.upper[i] || scaling.half_width()[i] == 0) fixed.emplace_back(k, limits.rhs[k]);
  }
  numerics::ConeProgramBuilder rows(limits.matrix.cols());
  if (!domain.linear_limits.empty()) {
    for (const auto& [coefficients, bound] : domain.linear_limits) {
      VectorX row = VectorX::Zero(limits.matrix.cols());
      double rhs = bound;
      for (Eigen::Index k = 0; k < n; ++k) {
        const int i = linear[static_cast<std::size_t>(k)];
        row[k] = coefficients[i] * scaling.half_width()[i];
        rhs -= coefficients[i] * scaling.centre()[i];
      }
      rows.add_inequalities(row, rhs);
    }
    const numerics::ConeProgram sums = rows.build(VectorX::Zero(limits.matrix.cols()));
    limits = add_inequalities(limits, sums.matrix, sums.rhs);
  }
  for (const Eigen::Index k : model_.list_massless_unknowns(data.terms, domain.upper)) fixed.emplace_back(k, 0.0);
  return data;
}

ConicRelaxation::ProgramResult ConicRelaxation::solve(const VariableDomain& domain, bool figures, bool rows,
                                                      double weight) const {
  FixedUnknowns fixed;
  const InnerData data = restrict_data(domain, fixed);
  InnerProgramBuilder builder(data, figures, rows);
  builder.add_unknown_constraints();
  std::vector<FigureRows> pieces;
  if (figures)
    for (std::size_t k = 0; k < data.figures.size(); ++k) builder.add_figure(k, pieces);
  if (figures) builder.add_limits(weight);
  if (rows) builder.add_residual(weight);
  PresolvedProgram presolved = ConePresolve(builder.build(pieces), fixed).run();
  ProgramResult result;
  if (!presolved.is_feasible) return result;
  VectorX unknowns = VectorX::Zero(builder.unknowns());
  for (const auto& [k, value] : fixed) unknowns[k] = value;
  if (!presolved.free_variables.empty()) {
    const numerics::ConeSolution solution = solve_cone_program(presolved.program);
    if (solution.status != numerics::ConeStatus::optimal) {
      result.bound = std::numeric_limits<double>::quiet_NaN();
      return result;
    }
    result.bound = solution.dual_value;
    for (std::size_t k = 0; k < presolved.free_variables.size(); ++k)
      if (presolved.free_variables[k] < unknowns.size())
        unknowns[presolved.free_variables[k]] = solution.x[static_cast<Eigen::Index>(k)];
  }
  result.status = numerics::ConeStatus::optimal;
  result.bound += presolved.constant;
  for (const auto& [figure, scale, limit] : data.figures)  // the cost of the program omits constants of linear figures
    if (figures && limit < 0 && figure.series.empty())
      result.bound += figure.weight / scale * figure.coefficients.tail(1)[0];
  result.unknowns = unknowns;
  return result;
}

RelaxationBound ConicRelaxation::make_bound(const ProgramResult& result, const VariableDomain& domain) const {
  RelaxationBound bound;
  // a numerical failure proves nothing
  bound.is_feasible = result.status == numerics::ConeStatus::optimal || std::isnan(result.bound);
  if (result.status != numerics::ConeStatus::optimal) return bound;
  bound.x = context_.scaling.to_variables(model_.recover_variables(context_.scaling.start(), result.unknowns));
  bound.x = bound.x.cwiseMax(domain.lower).cwiseMin(domain.upper);
  return bound;
}

RelaxationBound ConicRelaxation::minimise_residual(const VariableDomain& domain) const {
  if (data_.rows.rows() == 0) {
    RelaxationBound bound;
    bound.is_feasible = true;
    bound.residual = 0;
    return bound;
  }
  const ProgramResult result = solve(domain, false, true, 1);
  RelaxationBound bound = make_bound(result, domain);
  if (bound.x.size() > 0) bound.residual = std::max(0.0, result.bound);
  return bound;
}

RelaxationBound ConicRelaxation::minimise_constrained_figure(const VariableDomain& domain) const {
  if (data_.rows.rows() == 0) return minimise_figure(domain);
  RelaxationBound residual_bound = minimise_residual(domain);
  if (!residual_bound.is_feasible || !has_figure_) return residual_bound;
  if (residual_bound.residual > relaxed_residual_tolerance) return residual_bound;
  RelaxationBound best = minimise_penalised(domain, true);
  best.residual = residual_bound.residual;
  return best;
}

RelaxationBound ConicRelaxation::minimise_figure(const VariableDomain& domain) const {
  RelaxationBound best = minimise_penalised(domain, false);
  best.residual = 0;
  return best;
}

/// Increases the weights until rows and limits are satisfied; every solution gives a bound.
RelaxationBound ConicRelaxation::minimise_penalised(const VariableDomain& domain, bool rows) const {
  RelaxationBound best;
  double bound = -std::numeric_limits<double>::infinity();
  for (const double weight : penalty_weights) {
    const ProgramResult result = solve(domain, true, rows, weight);
    const RelaxationBound candidate = make_bound(result, domain);
    if (!rows && data_.limit_bounds.size() == 0) best.is_feasible = candidate.is_feasible;
    if (candidate.x.size() == 0) continue;
    best = candidate;
    bound = std::max(bound, result.bound);
    if (max_violation(result.unknowns, rows) < relaxed_residual_tolerance) break;
  }
  if (rows || data_.limit_bounds.size() > 0) best.is_feasible = true;
  if (best.x.size() > 0 && has_figure_) best.figure = figure_scale_ * bound;
  return best;
}

}  // namespace balance::design
