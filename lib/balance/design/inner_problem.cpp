#include "balance/design/inner_problem.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/design/inner_program.hpp"

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

}  // namespace balance::design
