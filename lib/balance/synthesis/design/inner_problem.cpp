#include "balance/synthesis/design/inner_problem.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Weight of the residual relative to a figure of size one.
constexpr double residual_penalty = 1e4;
/// Weight of a limit's violation relative to its bound.
constexpr double limit_penalty = 1e3;
/// Step in unit coordinates; the error of central differences is its square.
constexpr double inner_difference_step = 1e-5;
/// Singular directions of the free unknowns' rows that are weaker than the strongest by this factor are left to the
/// lengths.
constexpr double weak_direction_threshold = 0.03;

/// Multipliers · (matrix · x − right) of one piece of a figure, without its epigraph variable.
double multiplier_product(const AffineFigure& figure, const AffineSeries& series, const Eigen::Ref<const VectorX>& z,
                          const VectorX& w) {
  const VectorX values = series.rows * w;
  const Eigen::Index m = values.size();
  if (figure.figure == Statistic::rms) {
    const auto sizes = values.reshaped(series.components, series.time_weights.size()).colwise().squaredNorm();
    return z[0] * std::sqrt(sizes.dot(series.time_weights.transpose()));
  }
  if (figure.figure == Statistic::maximum) return z.head(m).dot(values);
  if (series.components == 1) return (z.head(m) - z.tail(m)).dot(values);
  double sum = 0;
  for (Eigen::Index k = 0; k < series.time_weights.size(); ++k)
    sum -= z.segment(k * (series.components + 1) + 1, series.components)
               .dot(values.segment(k * series.components, series.components));
  return sum;
}

}  // namespace

InnerProblem::InnerProblem(const SolverContext& context, const ConvexMassModel& model, Target target,
                           double figure_scale, double limit_margin)
    : context_(context), model_(model), target_(target), figure_scale_(figure_scale), limit_margin_(limit_margin) {}

bool InnerProblem::set_reference(const VectorX& u) {
  if (!wants_residual()) return true;
  try {
    goal_.emplace(context_.mechanism(u), context_.problem.goals, context_.options);
  } catch (const SpecError&) {
    return false;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return false;  // no configuration
  }
  return true;
}

std::optional<InnerData> InnerProblem::make_data(const VectorX& u) const {
  std::optional<AffineTerms> terms = model_.evaluate(u);
  if (!terms) return std::nullopt;
  InnerData data{std::move(*terms), {}, {}, {}};
  if (wants_residual()) {
    MatrixX rows;
    try {
      if (!goal_->rows(context_.mechanism(u), rows)) return std::nullopt;
    } catch (const SpecError&) {
      return std::nullopt;
    }
    data.rows = rows * data.terms.matrix;
    data.right = -rows * data.terms.constant;
    if (!data.rows.allFinite() || !data.right.allFinite()) return std::nullopt;
  }
  if (wants_figure() && !add_figures(u, data)) return std::nullopt;
  return data;
}

bool InnerProblem::add_figures(const VectorX& u, InnerData& data) const {
  const DesignModel::Capabilities capabilities = context_.problem.model->capabilities();
  if (capabilities.has_convex_terms) {
    const auto figures = context_.convex_terms(u, FigureSampling::coarse);
    if (!figures) return false;
    for (const AffineFigure& figure : *figures)
      data.figures.push_back({express_in_unknowns(figure, data.terms), figure_scale_});
  }
  if (!capabilities.has_convex_limits) return true;
  const auto limits = context_.convex_limits(u);
  if (!limits) return false;
  data.limit_bounds.resize(static_cast<Eigen::Index>(limits->size()));
  data.violation_floor = context_.problem.violation_floor;
  int l = 0;
  for (const ConvexLimit& limit : *limits) {
    const double scale = limit.bound != 0 ? std::abs(limit.bound) : 1;
    data.limit_bounds[l] = limit.bound / scale - (limit.bound != 0 ? limit_margin_ : 0);
    for (const AffineFigure& figure : limit.figures)
      data.figures.push_back({express_in_unknowns(figure, data.terms), scale, l});
    ++l;
  }
  return true;
}

InnerSolution InnerProblem::solve_at(const VectorX& u) const {
  InnerSolution solution;
  solution.u = u;
  ++context_.budget.geometries;
  if (!context_.infeasibility_reason(u).empty()) return solution;
  const std::optional<InnerData> data = make_data(u);
  if (!data) return solution;
  InnerProgramBuilder builder(*data, wants_figure(), wants_residual());
  builder.add_unknown_constraints();
  if (wants_figure())
    for (std::size_t k = 0; k < data->figures.size(); ++k) builder.add_figure(k, solution.pieces);
  if (wants_figure()) solution.first_limit_row = builder.add_limits(limit_penalty);
  MatrixX basis;
  if (wants_residual()) basis = builder.add_residual(target_ == Target::both ? residual_penalty : 1);
  solution.program = builder.build(solution.pieces);
  solution.cone = solve_cone_program(solution.program);
  if (solution.cone.status != numerics::ConeStatus::optimal) return solution;
  solution.is_found = true;
  solution.unknowns = solution.cone.x.head(builder.unknowns());
  evaluate_solution(*data, solution);
  if (wants_residual())
    solution.residual_multipliers =
        -basis * solution.cone.multipliers.segment(builder.first_of_residual(), basis.cols());
  return solution;
}

/// Computes figure, residual and value from the unknowns.
void InnerProblem::evaluate_solution(const InnerData& data, InnerSolution& solution) const {
  VectorX w(solution.unknowns.size() + 1);
  w << solution.unknowns, 1;
  VectorX violations = -data.limit_bounds;
  for (const auto& [figure, scale, limit] : data.figures)
    (limit < 0 ? solution.figure : violations[limit]) += figure.weight * figure(w) / (limit < 0 ? 1 : scale);
  if (data.violation_floor)
    solution.value = solution.figure = std::max(*data.violation_floor, numerics::max_coefficient(violations));
  else
    solution.value = solution.figure / figure_scale_ + limit_penalty * violations.cwiseMax(0).sum();
  if (!wants_residual()) return;
  solution.residual_vector = data.rows * solution.unknowns - data.right;
  solution.residual = solution.residual_vector.norm();
  solution.value += (target_ == Target::both ? residual_penalty : 1) * solution.residual;
}

double InnerProblem::lagrangian(const InnerSolution& solution, const InnerData& data) const {
  const VectorX &z = solution.cone.multipliers, &w = solution.unknowns;
  VectorX homogeneous(w.size() + 1);
  homogeneous << w, 1;
  const numerics::ConeProgram& limits = data.terms.constraints;
  const Eigen::Index linear = limits.linear_rows, cones = limits.rhs.size() - linear;
  const VectorX slack = limits.matrix * w - limits.rhs;
  double sum =
      z.head(linear).dot(slack.head(linear)) + z.segment(solution.program.linear_rows, cones).dot(slack.tail(cones));
  for (const auto& [figure, scale, limit] : data.figures)
    if (figure.series.empty())
      sum += (limit < 0 ? 1 : z[solution.first_limit_row + limit]) * figure.weight / scale *
             figure.coefficients.dot(homogeneous);
  for (const auto& piece : solution.pieces) {
    const auto& [figure, scale, limit] = data.figures[piece.figure];
    const AffineSeries& series = figure.series[piece.series];
    const Eigen::Index m = series.rows.rows(), samples = series.time_weights.size();
    const bool has_same_size =
        figure.figure == Statistic::rms || piece.rows == (figure.figure == Statistic::maximum ? m
                                                          : series.components == 1            ? 2 * m
                                                                                              : m + samples);
    if (!has_same_size) return std::numeric_limits<double>::quiet_NaN();  // the number of samples differs
    sum += multiplier_product(figure, series, z.segment(piece.first, piece.rows), homogeneous) / scale;
  }
  if (wants_residual()) sum += solution.residual_multipliers.dot(data.rows * w - data.right);
  return sum;
}

MatrixX InnerProblem::differences(const VectorX& u, Eigen::Index rows,
                                  const std::function<VectorX(const InnerData&)>& function) const {
  MatrixX slopes(rows, static_cast<Eigen::Index>(model_.outer().size()));
  slopes.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < model_.outer().size(); ++k) {
    const int i = model_.outer()[k];
    VectorX ahead = u, behind = u;
    ahead[i] = std::min(1.0, u[i] + inner_difference_step);
    behind[i] = std::max(-1.0, u[i] - inner_difference_step);
    const std::optional<InnerData> a = make_data(ahead), b = make_data(behind);
    if (!a || !b) continue;
    const VectorX change = function(*a) - function(*b);
    if (change.size() == rows) slopes.col(static_cast<Eigen::Index>(k)) = change / (ahead[i] - behind[i]);
  }
  return slopes;
}

VectorX InnerProblem::gradient(const InnerSolution& solution) const {
  return differences(solution.u, 1,
                     [&](const InnerData& data) { return VectorX::Constant(1, lagrangian(solution, data)).eval(); })
      .transpose();
}

MatrixX InnerProblem::reduced_jacobian(const InnerSolution& solution) const {
  MatrixX slopes = differences(solution.u, solution.residual_vector.size(), [&](const InnerData& data) {
    return VectorX(data.rows * solution.unknowns - data.right);
  });
  const std::optional<InnerData> data = make_data(solution.u);
  const MatrixX free = free_directions(solution);
  if (!data || free.cols() == 0 || !slopes.allFinite()) return slopes;
  const numerics::SingularValueDecomposition svd(data->rows * free, Eigen::ComputeThinU);
  const VectorX& s = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < s.size() && s[rank] > weak_direction_threshold * std::sqrt(solution.residual) * s[0] && s[rank] > 1e-14)
    ++rank;
  const MatrixX compensated = svd.matrixU().leftCols(rank);
  slopes -= compensated * (compensated.transpose() * slopes);
  return slopes;
}

/// Basis of the directions of the unknowns along the active constraints.
MatrixX InnerProblem::free_directions(const InnerSolution& solution) const {
  const Eigen::Index n = solution.unknowns.size();
  const VectorX &z = solution.cone.multipliers, &s = solution.cone.slack;
  const numerics::SecondOrderCone cone(solution.program.linear_rows, solution.program.cone_sizes);
  std::vector<VectorX> normals;
  for (Eigen::Index i = 0; i < solution.program.linear_rows; ++i)
    if (z[i] > std::max(s[i], 1e-9)) normals.push_back(solution.program.matrix.row(i).head(n).transpose());
  for (const auto& block : cone.blocks()) {
    if (block.first + block.size == cone.size()) break;  // the cone of the residual
    const double margin = s[block.first] - s.segment(block.first + 1, block.size - 1).norm();
    if (z[block.first] > std::max(margin, 1e-9))
      normals.push_back(solution.program.matrix.middleRows(block.first, block.size).leftCols(n).transpose() *
                        z.segment(block.first, block.size));
  }
  if (normals.empty()) return MatrixX::Identity(n, n);
  MatrixX normal_matrix(n, static_cast<Eigen::Index>(normals.size()));
  for (std::size_t k = 0; k < normals.size(); ++k)
    normal_matrix.col(static_cast<Eigen::Index>(k)) = normals[k].normalized();
  numerics::ColumnPivotingQr qr(normal_matrix);
  qr.setThreshold(1e-9);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(n, n);
  return q.rightCols(n - qr.rank());
}

namespace {

/// Thin QR factorisation of [a, −b], so that |a w − b| needs few rows: the triangle and the orthonormal basis.
struct CompressedRows {
  MatrixX rows, basis;
};
CompressedRows compress_rows(const MatrixX& rows) {
  const Eigen::Index k = std::min(rows.rows(), rows.cols());
  const Eigen::HouseholderQR<MatrixX> qr(rows);
  CompressedRows result;
  result.rows = qr.matrixQR().topRows(k).triangularView<Eigen::Upper>();
  result.basis = qr.householderQ() * MatrixX::Identity(rows.rows(), k);
  return result;
}

/// Weighted rows, whose norm is the root mean square.
MatrixX weight_rows(const AffineSeries& series) {
  MatrixX rows = series.rows;
  for (Eigen::Index k = 0; k < series.time_weights.size(); ++k)
    rows.middleRows(k * series.components, series.components) *= std::sqrt(std::max(0.0, series.time_weights[k]));
  return rows;
}

/// Number of variables for violations of limits.
Eigen::Index count_violation_variables(const InnerData& data) {
  return data.violation_floor ? std::min<Eigen::Index>(1, data.limit_bounds.size()) : data.limit_bounds.size();
}

Eigen::Index count_variables(const InnerData& data, bool figures, bool residual) {
  Eigen::Index count = data.terms.matrix.cols() + (residual ? 1 : 0);
  if (figures)
    for (const InnerFigure& one : data.figures) count += one.figure.series.empty() ? 0 : 1;
  return count + (figures ? count_violation_variables(data) : 0);
}

}  // namespace

MatrixX append_constant_column(const MatrixX& matrix, const VectorX& constant) {
  MatrixX all(matrix.rows(), matrix.cols() + 1);
  all << matrix, constant;
  return all;
}

AffineFigure express_in_unknowns(const AffineFigure& figure, const AffineTerms& terms) {
  AffineFigure result{figure.weight, {}, figure.figure, {}};
  if (const Eigen::Index p = figure.coefficients.size(); p > 0) {
    result.coefficients =
        append_constant_column(terms.matrix.topRows(p), terms.constant.head(p)).transpose() * figure.coefficients;
    return result;
  }
  for (const AffineSeries& series : figure.series) {
    const Eigen::Index p = series.rows.cols() - 1;
    const MatrixX matrix = series.rows.leftCols(p) * terms.matrix.topRows(p);
    const VectorX constant = series.rows.leftCols(p) * terms.constant.head(p) + series.rows.col(p);
    result.series.push_back({append_constant_column(matrix, constant), series.components, series.time_weights});
  }
  return result;
}

void mark_active_parameters(const std::vector<AffineFigure>& figures, std::vector<bool>& is_active_parameter) {
  for (const AffineFigure& figure : figures) {
    for (Eigen::Index k = 0; k < figure.coefficients.size(); ++k)
      if (figure.coefficients[k] != 0) is_active_parameter[static_cast<std::size_t>(k)] = true;
    for (const AffineSeries& series : figure.series)
      for (Eigen::Index k = 0; k + 1 < series.rows.cols(); ++k)
        if (!series.rows.col(k).isZero(0)) is_active_parameter[static_cast<std::size_t>(k)] = true;
  }
}

InnerProgramBuilder::InnerProgramBuilder(const InnerData& data, bool figures, bool residual)
    : data_(data),
      n_(data.terms.matrix.cols()),
      variables_(count_variables(data, figures, residual)),
      epigraph_(n_),
      rows_(variables_),
      cost_(VectorX::Zero(variables_)),
      limit_rhs_(data.limit_bounds),
      limit_rows_(MatrixX::Zero(data.limit_bounds.size(), variables_)) {}

void InnerProgramBuilder::add_unknown_constraints() {
  const numerics::ConeProgram& limits = data_.terms.constraints;
  rows_.add_inequalities(pad_columns(limits.matrix.topRows(limits.linear_rows)), limits.rhs.head(limits.linear_rows));
  Eigen::Index row = limits.linear_rows;
  for (const Eigen::Index size : limits.cone_sizes) {
    rows_.add_cone(pad_columns(-limits.matrix.middleRows(row, size)), limits.rhs.segment(row, size));
    row += size;
  }
}

void InnerProgramBuilder::add_figure(std::size_t index, std::vector<FigureRows>& pieces) {
  const auto& [figure, scale, limit] = data_.figures[index];
  if (figure.series.empty()) {
    const VectorX sum = figure.weight / scale * figure.coefficients;
    if (limit < 0) return void(cost_.head(n_) += sum.head(n_));
    limit_rows_.row(limit).head(n_) += sum.head(n_).transpose();
    limit_rhs_[limit] -= sum[n_];
    return;
  }
  const Eigen::Index t = epigraph_++;
  (limit < 0 ? cost_[t] : limit_rows_(limit, t)) = figure.weight;
  for (std::size_t s = 0; s < figure.series.size(); ++s) {
    const AffineSeries& series = figure.series[s];
    const bool linear =
        figure.figure == Statistic::maximum || (figure.figure == Statistic::peak && series.components == 1);
    const Eigen::Index first_row = linear ? rows_.linear_row_count() : rows_.conic_row_count();
    if (linear)
      add_bounds(series, figure.figure == Statistic::peak, scale, t);
    else if (figure.figure == Statistic::peak)
      for (Eigen::Index k = 0; k < series.time_weights.size(); ++k)
        add_norm(series.rows.middleRows(k * series.components, series.components), scale, t);
    else
      add_norm(compress_rows(weight_rows(series)).rows, scale, t);
    const Eigen::Index rows = (linear ? rows_.linear_row_count() : rows_.conic_row_count()) - first_row;
    pieces.push_back({index, s, linear ? first_row : -1 - first_row, rows});  // cones follow all linear rows
  }
}

Eigen::Index InnerProgramBuilder::add_limits(double weight) {
  const Eigen::Index first = rows_.linear_row_count(), first_violation = epigraph_;
  const std::optional<double>& violation_floor = data_.violation_floor;
  epigraph_ += count_violation_variables(data_);
  for (Eigen::Index l = 0; l < limit_rhs_.size(); ++l)
    add_bound(l, violation_floor ? first_violation : first_violation + l);
  for (Eigen::Index k = first_violation; k < epigraph_; ++k) {
    cost_[k] = violation_floor ? 1 : weight;
    rows_.add_inequalities(-VectorX::Unit(variables_, k), violation_floor ? -*violation_floor : 0);
  }
  return first;
}

/// Σ figures − violation ≤ bound
void InnerProgramBuilder::add_bound(Eigen::Index l, Eigen::Index violation) {
  VectorX row = limit_rows_.row(l).transpose();
  row[violation] = -1;
  rows_.add_inequalities(row, limit_rhs_[l]);
}

MatrixX InnerProgramBuilder::add_residual(double weight) {
  const Eigen::Index s = variables_ - 1;
  cost_[s] = weight;
  const CompressedRows compressed = compress_rows(append_constant_column(data_.rows, -data_.right));
  residual_row_ = rows_.conic_row_count();
  add_norm(compressed.rows, 1, s);
  return compressed.basis;
}

numerics::ConeProgram InnerProgramBuilder::build(std::vector<FigureRows>& pieces) const {
  for (FigureRows& piece : pieces)
    if (piece.first < 0) piece.first = rows_.linear_row_count() + (-1 - piece.first);
  return rows_.build(cost_);
}

MatrixX InnerProgramBuilder::pad_columns(const MatrixX& rows) const {
  MatrixX padded = MatrixX::Zero(rows.rows(), variables_);
  padded.leftCols(rows.cols()) = rows;
  return padded;
}

/// rows (w, 1) ≤ scale · t, and for a magnitude −rows (w, 1) ≤ scale · t
void InnerProgramBuilder::add_bounds(const AffineSeries& series, bool is_magnitude, double scale, Eigen::Index t) {
  const Eigen::Index m = series.rows.rows();
  MatrixX rows = MatrixX::Zero(is_magnitude ? 2 * m : m, variables_);
  VectorX limits(rows.rows());
  rows.topLeftCorner(m, n_) = series.rows.leftCols(n_) / scale;
  limits.head(m) = -series.rows.col(n_) / scale;
  if (is_magnitude) {
    rows.bottomLeftCorner(m, n_) = -rows.topLeftCorner(m, n_);
    limits.tail(m) = -limits.head(m);
  }
  rows.col(t).setConstant(-1);
  rows_.add_inequalities(rows, limits);
}

/// |rows (w, 1)| ≤ scale · t
void InnerProgramBuilder::add_norm(const MatrixX& rows, double scale, Eigen::Index t) {
  MatrixX cone = MatrixX::Zero(rows.rows() + 1, variables_);
  cone(0, t) = 1;
  cone.bottomLeftCorner(rows.rows(), n_) = rows.leftCols(n_) / scale;
  VectorX constant = VectorX::Zero(rows.rows() + 1);
  constant.tail(rows.rows()) = rows.col(n_) / scale;
  rows_.add_cone(cone, constant);
}

}  // namespace balance::design
