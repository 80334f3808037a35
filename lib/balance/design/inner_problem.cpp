#include "balance/design/inner_problem.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/design/inner_program.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Weight of the residual against a figure of size one.
constexpr double of_residual = 1e4;
/// Weight of what a limit is missed by, in parts of its bound.
constexpr double of_limits = 1e3;
/// Difference of unit coordinates; the error of central ones is its square.
constexpr double difference = 1e-5;
/// Directions in which the rows of the movable unknowns are this much weaker than in the strongest are left to the lengths.
constexpr double weak = 0.03;

/// Multipliers · (matrix · x − right) of one piece of a figure, without its epigraph.
double pulled(const LinearFigure& figure, const PlaceRows& one, const Eigen::Ref<const VectorX>& z, const VectorX& w) {
  const VectorX values = one.rows * w;
  const Eigen::Index m = values.size();
  if (figure.figure == Figure::rms) {
    const auto sizes = values.reshaped(one.components, one.share.size()).colwise().squaredNorm();
    return z[0] * std::sqrt(sizes.dot(one.share.transpose()));
  }
  if (one.components == 1) return (z.head(m) - z.tail(m)).dot(values);
  double sum = 0;
  for (Eigen::Index k = 0; k < one.share.size(); ++k)
    sum -=
        z.segment(k * (one.components + 1) + 1, one.components).dot(values.segment(k * one.components, one.components));
  return sum;
}

}  // namespace

InnerProblem::InnerProblem(const Context& context, const InertialModel& model, Aim aim, double size, double spare)
    : context_(context), model_(model), aim_(aim), size_(size), spare_(spare) {}

bool InnerProblem::centre(const VectorX& u) {
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

std::optional<InnerData> InnerProblem::data(const VectorX& u) const {
  std::optional<InertialTerms> terms = model_.at(u);
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
  } catch (const OutOfTime&) {
    return std::nullopt;
  }
  return data;
}

bool InnerProblem::add_figures(const VectorX& u, InnerData& data) const {
  const VectorX x = context_.box.numbers(u);
  if (context_.problem.figures_at) {
    const auto figures = context_.problem.figures_at(x);
    if (!figures) return false;
    for (const LinearFigure& figure : *figures) data.figures.push_back({of_unknowns(figure, data.terms), size_});
  }
  if (!context_.problem.bounded_at) return true;
  const auto limits = context_.problem.bounded_at(x);
  if (!limits) return false;
  data.bounds.resize(static_cast<Eigen::Index>(limits->size()));
  data.least_beyond = context_.problem.least_beyond;
  int l = 0;
  for (const BoundedFigures& limit : *limits) {
    const double size = limit.bound != 0 ? std::abs(limit.bound) : 1;
    data.bounds[l] = limit.bound / size - (limit.bound > 0 ? spare_ : 0);
    for (const LinearFigure& figure : limit.figures) data.figures.push_back({of_unknowns(figure, data.terms), size, l});
    ++l;
  }
  return true;
}

InnerSolution InnerProblem::at(const VectorX& u) const {
  InnerSolution solution;
  solution.u = u;
  ++context_.budget.geometries;
  if (!context_.obstacle(u).empty()) return solution;
  const std::optional<InnerData> here = data(u);
  if (!here) return solution;
  InnerProgram builder(*here, wants_figure(), wants_residual());
  builder.add_limits();
  if (wants_figure())
    for (std::size_t k = 0; k < here->figures.size(); ++k) builder.add_figure(k, solution.pieces);
  if (wants_figure()) solution.bounds = builder.add_bounds(of_limits);
  MatrixX basis;
  if (wants_residual()) basis = builder.add_residual(aim_ == Aim::both ? of_residual : 1);
  solution.program = builder.finish(solution.pieces);
  solution.cone = minimise(solution.program);
  if (solution.cone.status != ConeStatus::solved) return solution;
  solution.found = true;
  solution.unknowns = solution.cone.x.head(builder.unknowns());
  measure(*here, solution);
  if (wants_residual())
    solution.pull = -basis * solution.cone.multipliers.segment(builder.first_of_residual(), basis.cols());
  return solution;
}

/// What the unknowns come to.
void InnerProblem::measure(const InnerData& data, InnerSolution& solution) const {
  VectorX w(solution.unknowns.size() + 1);
  w << solution.unknowns, 1;
  VectorX beyond = -data.bounds;
  for (const auto& [figure, size, limit] : data.figures)
    (limit < 0 ? solution.figure : beyond[limit]) += figure.weight * figure(w) / (limit < 0 ? 1 : size);
  if (data.least_beyond)
    solution.value = solution.figure = std::max(*data.least_beyond, max_coefficient(beyond));
  else
    solution.value = solution.figure / size_ + of_limits * beyond.cwiseMax(0).sum();
  if (!wants_residual()) return;
  solution.left = data.rows * solution.unknowns - data.right;
  solution.residual = solution.left.norm();
  solution.value += (aim_ == Aim::both ? of_residual : 1) * solution.residual;
}

double InnerProblem::lagrangian(const InnerSolution& solution, const InnerData& data) const {
  const VectorX &z = solution.cone.multipliers, &w = solution.unknowns;
  VectorX with(w.size() + 1);
  with << w, 1;
  const ConeProgram& limits = data.terms.limits;
  const Eigen::Index linear = limits.linear, cones = limits.right.size() - linear;
  const VectorX slack = limits.matrix * w - limits.right;
  double sum =
      z.head(linear).dot(slack.head(linear)) + z.segment(solution.program.linear, cones).dot(slack.tail(cones));
  for (const auto& [figure, size, limit] : data.figures)
    if (figure.series.empty())
      sum += (limit < 0 ? 1 : z[solution.bounds + limit]) * figure.weight / size * figure.coefficients.dot(with);
  for (const auto& piece : solution.pieces) {
    const auto& [figure, size, limit] = data.figures[piece.figure];
    const PlaceRows& one = figure.series[piece.series];
    const Eigen::Index m = one.rows.rows(), places = one.share.size();
    const bool same = figure.figure == Figure::rms || piece.rows == (one.components == 1 ? 2 * m : m + places);
    if (!same) return std::numeric_limits<double>::quiet_NaN();  // another number of places
    sum += pulled(figure, one, z.segment(piece.first, piece.rows), with) / size;
  }
  if (wants_residual()) sum += solution.pull.dot(data.rows * w - data.right);
  return sum;
}

MatrixX InnerProblem::differences(const VectorX& u, Eigen::Index rows,
                                  const std::function<VectorX(const InnerData&)>& of) const {
  MatrixX slopes(rows, static_cast<Eigen::Index>(model_.outer().size()));
  slopes.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < model_.outer().size(); ++k) {
    const int i = model_.outer()[k];
    VectorX ahead = u, behind = u;
    ahead[i] = std::min(1.0, u[i] + difference);
    behind[i] = std::max(-1.0, u[i] - difference);
    const std::optional<InnerData> a = data(ahead), b = data(behind);
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
  MatrixX slopes = differences(solution.u, solution.left.size(), [&](const InnerData& data) {
    return VectorX(data.rows * solution.unknowns - data.right);
  });
  const std::optional<InnerData> here = data(solution.u);
  const MatrixX free = movable(solution);
  if (!here || free.cols() == 0 || !slopes.allFinite()) return slopes;
  const SingularValueDecomposition svd(here->rows * free, Eigen::ComputeThinU);
  const VectorX& s = svd.singularValues();
  Eigen::Index strong = 0;
  while (strong < s.size() && s[strong] > weak * std::sqrt(solution.residual) * s[0] && s[strong] > 1e-14) ++strong;
  const MatrixX undone = svd.matrixU().leftCols(strong);
  slopes -= undone * (undone.transpose() * slopes);
  return slopes;
}

/// Directions of the unknowns that keep to the limits that hold them.
MatrixX InnerProblem::movable(const InnerSolution& solution) const {
  const Eigen::Index n = solution.unknowns.size();
  const VectorX &z = solution.cone.multipliers, &s = solution.cone.slack;
  const SecondOrderCone cone(solution.program.linear, solution.program.cones);
  std::vector<VectorX> normals;
  for (Eigen::Index i = 0; i < solution.program.linear; ++i)
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

}  // namespace balance::designing
