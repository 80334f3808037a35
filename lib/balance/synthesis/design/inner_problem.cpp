#include "balance/synthesis/design/inner_problem.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Weight of the residual against a figure of size one.
constexpr double residual_penalty = 1e4;
/// Weight of what a limit is missed by, in parts of its bound.
constexpr double limit_penalty = 1e3;
/// Difference of unit coordinates; the error of central ones is its square.
constexpr double inner_difference_step = 1e-5;
/// Directions in which the rows of the movable unknowns are this much weaker than in the strongest are left to the lengths.
constexpr double weak_direction_threshold = 0.03;

/// Multipliers · (matrix · x − right) of one piece of a figure, without its epigraph.
double multiplier_product(const AffineFigure& figure, const AffineSeries& one, const Eigen::Ref<const VectorX>& z,
                          const VectorX& w) {
  const VectorX values = one.rows * w;
  const Eigen::Index m = values.size();
  if (figure.figure == Statistic::rms) {
    const auto sizes = values.reshaped(one.components, one.time_weights.size()).colwise().squaredNorm();
    return z[0] * std::sqrt(sizes.dot(one.time_weights.transpose()));
  }
  if (one.components == 1) return (z.head(m) - z.tail(m)).dot(values);
  double sum = 0;
  for (Eigen::Index k = 0; k < one.time_weights.size(); ++k)
    sum -=
        z.segment(k * (one.components + 1) + 1, one.components).dot(values.segment(k * one.components, one.components));
  return sum;
}

}  // namespace

InnerProblem::InnerProblem(const SolverContext& context, const ConvexMassModel& model, Target aim, double size,
                           double spare)
    : context_(context), model_(model), aim_(aim), figure_scale_(size), limit_margin_(spare) {}

bool InnerProblem::set_reference(const VectorX& u) {
  if (!wants_residual()) return true;
  try {
    goal_.emplace(context_.mechanism(u), context_.problem.goals, context_.options);
  } catch (const SpecError&) {
    return false;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return false;  // or no configuration
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
  try {
    if (wants_figure() && !add_figures(u, data)) return std::nullopt;
  } catch (const DeadlineExceeded&) {
    return std::nullopt;
  }
  return data;
}

bool InnerProblem::add_figures(const VectorX& u, InnerData& data) const {
  const VectorX x = context_.scaling.to_variables(u);
  if (context_.problem.convex_terms_at) {
    const auto figures = context_.problem.convex_terms_at(x);
    if (!figures) return false;
    for (const AffineFigure& figure : *figures)
      data.figures.push_back({express_in_unknowns(figure, data.terms), figure_scale_});
  }
  if (!context_.problem.convex_limits) return true;
  const auto limits = context_.problem.convex_limits(x);
  if (!limits) return false;
  data.limit_bounds.resize(static_cast<Eigen::Index>(limits->size()));
  data.violation_floor = context_.problem.violation_floor;
  int l = 0;
  for (const ConvexLimit& limit : *limits) {
    const double size = limit.bound != 0 ? std::abs(limit.bound) : 1;
    data.limit_bounds[l] = limit.bound / size - (limit.bound > 0 ? limit_margin_ : 0);
    for (const AffineFigure& figure : limit.figures)
      data.figures.push_back({express_in_unknowns(figure, data.terms), size, l});
    ++l;
  }
  return true;
}

InnerSolution InnerProblem::solve_at(const VectorX& u) const {
  InnerSolution solution;
  solution.u = u;
  ++context_.budget.geometries;
  if (!context_.infeasibility_reason(u).empty()) return solution;
  const std::optional<InnerData> here = make_data(u);
  if (!here) return solution;
  InnerProgramBuilder builder(*here, wants_figure(), wants_residual());
  builder.add_unknown_constraints();
  if (wants_figure())
    for (std::size_t k = 0; k < here->figures.size(); ++k) builder.add_figure(k, solution.pieces);
  if (wants_figure()) solution.first_limit_row = builder.add_limits(limit_penalty);
  MatrixX basis;
  if (wants_residual()) basis = builder.add_residual(aim_ == Target::both ? residual_penalty : 1);
  solution.program = builder.build(solution.pieces);
  solution.cone = solve_cone_program(solution.program);
  if (solution.cone.status != ConeStatus::optimal) return solution;
  solution.is_found = true;
  solution.unknowns = solution.cone.x.head(builder.unknowns());
  evaluate_solution(*here, solution);
  if (wants_residual())
    solution.residual_multipliers =
        -basis * solution.cone.multipliers.segment(builder.first_of_residual(), basis.cols());
  return solution;
}

/// What the unknowns come to.
void InnerProblem::evaluate_solution(const InnerData& data, InnerSolution& solution) const {
  VectorX w(solution.unknowns.size() + 1);
  w << solution.unknowns, 1;
  VectorX beyond = -data.limit_bounds;
  for (const auto& [figure, size, limit] : data.figures)
    (limit < 0 ? solution.figure : beyond[limit]) += figure.weight * figure(w) / (limit < 0 ? 1 : size);
  if (data.violation_floor)
    solution.value = solution.figure = std::max(*data.violation_floor, max_coefficient(beyond));
  else
    solution.value = solution.figure / figure_scale_ + limit_penalty * beyond.cwiseMax(0).sum();
  if (!wants_residual()) return;
  solution.residual_vector = data.rows * solution.unknowns - data.right;
  solution.residual = solution.residual_vector.norm();
  solution.value += (aim_ == Target::both ? residual_penalty : 1) * solution.residual;
}

double InnerProblem::lagrangian(const InnerSolution& solution, const InnerData& data) const {
  const VectorX &z = solution.cone.multipliers, &w = solution.unknowns;
  VectorX with(w.size() + 1);
  with << w, 1;
  const ConeProgram& limits = data.terms.constraints;
  const Eigen::Index linear = limits.linear_rows, cones = limits.rhs.size() - linear;
  const VectorX slack = limits.matrix * w - limits.rhs;
  double sum =
      z.head(linear).dot(slack.head(linear)) + z.segment(solution.program.linear_rows, cones).dot(slack.tail(cones));
  for (const auto& [figure, size, limit] : data.figures)
    if (figure.series.empty())
      sum +=
          (limit < 0 ? 1 : z[solution.first_limit_row + limit]) * figure.weight / size * figure.coefficients.dot(with);
  for (const auto& piece : solution.pieces) {
    const auto& [figure, size, limit] = data.figures[piece.figure];
    const AffineSeries& one = figure.series[piece.series];
    const Eigen::Index m = one.rows.rows(), places = one.time_weights.size();
    const bool same = figure.figure == Statistic::rms || piece.rows == (one.components == 1 ? 2 * m : m + places);
    if (!same) return std::numeric_limits<double>::quiet_NaN();  // another number of places
    sum += multiplier_product(figure, one, z.segment(piece.first, piece.rows), with) / size;
  }
  if (wants_residual()) sum += solution.residual_multipliers.dot(data.rows * w - data.right);
  return sum;
}

MatrixX InnerProblem::differences(const VectorX& u, Eigen::Index rows,
                                  const std::function<VectorX(const InnerData&)>& of) const {
  MatrixX slopes(rows, static_cast<Eigen::Index>(model_.outer().size()));
  slopes.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < model_.outer().size(); ++k) {
    const int i = model_.outer()[k];
    VectorX ahead = u, behind = u;
    ahead[i] = std::min(1.0, u[i] + inner_difference_step);
    behind[i] = std::max(-1.0, u[i] - inner_difference_step);
    const std::optional<InnerData> a = make_data(ahead), b = make_data(behind);
    if (!a || !b) continue;
    const VectorX change = of(*a) - of(*b);
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
  const std::optional<InnerData> here = make_data(solution.u);
  const MatrixX free = free_directions(solution);
  if (!here || free.cols() == 0 || !slopes.allFinite()) return slopes;
  const SingularValueDecomposition svd(here->rows * free, Eigen::ComputeThinU);
  const VectorX& s = svd.singularValues();
  Eigen::Index strong = 0;
  while (strong < s.size() && s[strong] > weak_direction_threshold * std::sqrt(solution.residual) * s[0] &&
         s[strong] > 1e-14)
    ++strong;
  const MatrixX undone = svd.matrixU().leftCols(strong);
  slopes -= undone * (undone.transpose() * slopes);
  return slopes;
}

/// Directions of the unknowns that keep to the limits that hold them.
MatrixX InnerProblem::free_directions(const InnerSolution& solution) const {
  const Eigen::Index n = solution.unknowns.size();
  const VectorX &z = solution.cone.multipliers, &s = solution.cone.slack;
  const SecondOrderCone cone(solution.program.linear_rows, solution.program.cone_sizes);
  std::vector<VectorX> normals;
  for (Eigen::Index i = 0; i < solution.program.linear_rows; ++i)
    if (z[i] > std::max(s[i], 1e-9)) normals.push_back(solution.program.matrix.row(i).head(n).transpose());
  for (const auto& block : cone.blocks()) {
    if (block.first + block.size == cone.size()) break;  // the residual's own
    const double margin = s[block.first] - s.segment(block.first + 1, block.size - 1).norm();
    if (z[block.first] > std::max(margin, 1e-9))
      normals.push_back(solution.program.matrix.middleRows(block.first, block.size).leftCols(n).transpose() *
                        z.segment(block.first, block.size));
  }
  if (normals.empty()) return MatrixX::Identity(n, n);
  MatrixX all(n, static_cast<Eigen::Index>(normals.size()));
  for (std::size_t k = 0; k < normals.size(); ++k) all.col(static_cast<Eigen::Index>(k)) = normals[k].normalized();
  ColumnPivotingQr qr(all);
  qr.setThreshold(1e-9);
  const MatrixX q = qr.householderQ() * MatrixX::Identity(n, n);
  return q.rightCols(n - qr.rank());
}

namespace {

/// The triangle of [a, −b], so that |a w − b| takes few rows, and the basis that it is written in.
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

/// Rows whose norm is the root of the mean square.
MatrixX weight_rows(const AffineSeries& one) {
  MatrixX rows = one.rows;
  for (Eigen::Index k = 0; k < one.time_weights.size(); ++k)
    rows.middleRows(k * one.components, one.components) *= std::sqrt(std::max(0.0, one.time_weights[k]));
  return rows;
}

/// Unknowns that say by how much limits are missed.
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
  for (const AffineSeries& one : figure.series) {
    const Eigen::Index p = one.rows.cols() - 1;
    const MatrixX by_unknown = one.rows.leftCols(p) * terms.matrix.topRows(p);
    const VectorX rest = one.rows.leftCols(p) * terms.constant.head(p) + one.rows.col(p);
    result.series.push_back({append_constant_column(by_unknown, rest), one.components, one.time_weights});
  }
  return result;
}

void mark_active_parameters(const std::vector<AffineFigure>& figures, std::vector<bool>& matters) {
  for (const AffineFigure& figure : figures) {
    for (Eigen::Index k = 0; k < figure.coefficients.size(); ++k)
      if (figure.coefficients[k] != 0) matters[static_cast<std::size_t>(k)] = true;
    for (const AffineSeries& one : figure.series)
      for (Eigen::Index k = 0; k + 1 < one.rows.cols(); ++k)
        if (!one.rows.col(k).isZero(0)) matters[static_cast<std::size_t>(k)] = true;
  }
}

InnerProgramBuilder::InnerProgramBuilder(const InnerData& data, bool figures, bool residual)
    : data_(data),
      n_(data.terms.matrix.cols()),
      variables_(count_variables(data, figures, residual)),
      epigraph_(n_),
      rows_(variables_),
      cost_(VectorX::Zero(variables_)),
      right_(data.limit_bounds),
      bounded_(MatrixX::Zero(data.limit_bounds.size(), variables_)) {}

void InnerProgramBuilder::add_unknown_constraints() {
  const ConeProgram& limits = data_.terms.constraints;
  rows_.add_inequalities(pad_columns(limits.matrix.topRows(limits.linear_rows)), limits.rhs.head(limits.linear_rows));
  Eigen::Index row = limits.linear_rows;
  for (const Eigen::Index size : limits.cone_sizes) {
    rows_.add_cone(pad_columns(-limits.matrix.middleRows(row, size)), limits.rhs.segment(row, size));
    row += size;
  }
}

void InnerProgramBuilder::add_figure(std::size_t index, std::vector<FigureRows>& pieces) {
  const auto& [figure, size, limit] = data_.figures[index];
  if (figure.series.empty()) {
    const VectorX sum = figure.weight / size * figure.coefficients;
    if (limit < 0) return void(cost_.head(n_) += sum.head(n_));
    bounded_.row(limit).head(n_) += sum.head(n_).transpose();
    right_[limit] -= sum[n_];
    return;
  }
  const Eigen::Index t = epigraph_++;
  (limit < 0 ? cost_[t] : bounded_(limit, t)) = figure.weight;
  for (std::size_t s = 0; s < figure.series.size(); ++s) {
    const AffineSeries& one = figure.series[s];
    const bool linear = figure.figure == Statistic::peak && one.components == 1;
    const Eigen::Index before = linear ? rows_.linear_row_count() : rows_.conic_row_count();
    if (linear)
      add_peak(one, size, t);
    else if (figure.figure == Statistic::peak)
      for (Eigen::Index k = 0; k < one.time_weights.size(); ++k)
        add_norm(one.rows.middleRows(k * one.components, one.components), size, t);
    else
      add_norm(compress_rows(weight_rows(one)).rows, size, t);
    const Eigen::Index rows = (linear ? rows_.linear_row_count() : rows_.conic_row_count()) - before;
    pieces.push_back({index, s, linear ? before : -1 - before, rows});  // cones stand behind all linear rows
  }
}

Eigen::Index InnerProgramBuilder::add_limits(double weight) {
  const Eigen::Index first = rows_.linear_row_count(), missed = epigraph_;
  const std::optional<double>& worst = data_.violation_floor;
  epigraph_ += count_violation_variables(data_);
  for (Eigen::Index l = 0; l < right_.size(); ++l) add_bound(l, worst ? missed : missed + l);
  for (Eigen::Index k = missed; k < epigraph_; ++k) {
    cost_[k] = worst ? 1 : weight;
    rows_.add_inequalities(-VectorX::Unit(variables_, k), worst ? -*worst : 0);
  }
  return first;
}

/// Σ figures − missed ≤ bound
void InnerProgramBuilder::add_bound(Eigen::Index l, Eigen::Index missed) {
  VectorX row = bounded_.row(l).transpose();
  row[missed] = -1;
  rows_.add_inequalities(row, right_[l]);
}

MatrixX InnerProgramBuilder::add_residual(double weight) {
  const Eigen::Index s = variables_ - 1;
  cost_[s] = weight;
  const CompressedRows small = compress_rows(append_constant_column(data_.rows, -data_.right));
  residual_ = rows_.conic_row_count();
  add_norm(small.rows, 1, s);
  return small.basis;
}

ConeProgram InnerProgramBuilder::build(std::vector<FigureRows>& pieces) const {
  for (FigureRows& piece : pieces)
    if (piece.first < 0) piece.first = rows_.linear_row_count() + (-1 - piece.first);
  return rows_.build(cost_);
}

MatrixX InnerProgramBuilder::pad_columns(const MatrixX& rows) const {
  MatrixX all = MatrixX::Zero(rows.rows(), variables_);
  all.leftCols(rows.cols()) = rows;
  return all;
}

/// ± rows (w, 1) ≤ size · t
void InnerProgramBuilder::add_peak(const AffineSeries& one, double size, Eigen::Index t) {
  const Eigen::Index m = one.rows.rows();
  MatrixX rows = MatrixX::Zero(2 * m, variables_);
  rows.topLeftCorner(m, n_) = one.rows.leftCols(n_) / size;
  rows.bottomLeftCorner(m, n_) = -one.rows.leftCols(n_) / size;
  rows.col(t).setConstant(-1);
  VectorX limits(2 * m);
  limits << -one.rows.col(n_) / size, one.rows.col(n_) / size;
  rows_.add_inequalities(rows, limits);
}

/// |rows (w, 1)| ≤ size · t
void InnerProgramBuilder::add_norm(const MatrixX& rows, double size, Eigen::Index t) {
  MatrixX cone = MatrixX::Zero(rows.rows() + 1, variables_);
  cone(0, t) = 1;
  cone.bottomLeftCorner(rows.rows(), n_) = rows.leftCols(n_) / size;
  VectorX constant = VectorX::Zero(rows.rows() + 1);
  constant.tail(rows.rows()) = rows.col(n_) / size;
  rows_.add_cone(cone, constant);
}

}  // namespace balance::design
