#include "balance/synthesis/design/order_cost.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace balance::design {

namespace {

constexpr Eigen::Index phase_count = 360;  ///< over half a period

/// Two components whose norm is the radius of one of the circles that an order consists of.
MatrixX circle_rows(const OrderMatrices& matrices, bool is_forward) {
  const double sign = is_forward ? 1 : -1;
  MatrixX rows(2, matrices.cosine.cols());
  rows.row(0) = (matrices.cosine.row(0) + sign * matrices.sine.row(1)) / 2;
  rows.row(1) = (matrices.cosine.row(1) - sign * matrices.sine.row(0)) / 2;
  return rows;
}

/// Rows whose norms add up to the order's size; empty in space.
std::vector<MatrixX> list_norms(const OrderMatrices& matrices, results::OrderPart part) {
  const Eigen::Index components = matrices.cosine.rows();
  if (components == 1) {
    MatrixX rows(2, matrices.cosine.cols());
    rows << matrices.cosine, matrices.sine;
    return {rows};
  }
  if (components != 2) return {};
  if (part != results::OrderPart::whole) return {circle_rows(matrices, part == results::OrderPart::forward)};
  return {circle_rows(matrices, true), circle_rows(matrices, false)};
}

VectorX append_one(const VectorX& parameters) {
  VectorX all(parameters.size() + 1);
  all << parameters, 1;
  return all;
}

double largest_singular_value(const OrderMatrices& matrices, const VectorX& parameters, VectorX* gradient) {
  const VectorX all = append_one(parameters);
  MatrixX ellipse(matrices.cosine.rows(), 2);
  ellipse << matrices.cosine * all, matrices.sine * all;
  const numerics::SingularValueDecomposition svd(ellipse, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (gradient != nullptr) {
    const Eigen::RowVectorXd u = svd.matrixU().col(0).transpose();
    const VectorX slope =
        (svd.matrixV()(0, 0) * (u * matrices.cosine) + svd.matrixV()(1, 0) * (u * matrices.sine)).transpose();
    *gradient = slope.head(parameters.size());
  }
  return svd.singularValues()[0];
}

double sum_norms(const std::vector<MatrixX>& norms, const VectorX& parameters, VectorX* gradient) {
  const VectorX all = append_one(parameters);
  if (gradient != nullptr) gradient->setZero(parameters.size());
  double sum = 0;
  for (const MatrixX& rows : norms) {
    const VectorX value = rows * all;
    const double norm = value.norm();
    sum += norm;
    if (gradient != nullptr && norm > 0) *gradient += (rows.transpose() * value / norm).head(parameters.size());
  }
  return sum;
}

AffineSeries make_series(MatrixX rows, Eigen::Index components, Eigen::Index samples) {
  AffineSeries series;
  series.rows = std::move(rows);
  series.components = components;
  series.time_weights.setOnes(samples);
  return series;
}

}  // namespace

OrderMatrices project_on_order(const AffineSeries& series, double order, const results::UniformTurning& turning,
                               long samples) {
  if (!results::has_order(order, turning.turns))
    throw std::invalid_argument("a run of " + std::to_string(turning.turns) + " turns has no order " +
                                results::format_order(order));
  if (const long needed = results::count_needed_samples(order, turning.turns); samples < needed)
    throw std::invalid_argument("order " + results::format_order(order) + " needs at least " + std::to_string(needed) +
                                " samples");
  const Eigen::Index points = series.time_weights.size() - 1, moments = samples - 1, stride = points / moments;
  if (points != stride * moments) throw std::invalid_argument("the acceleration jumps along a motion with orders");
  VectorX angle(moments + 1);
  for (Eigen::Index k = 0; k <= moments; ++k)
    angle[k] = std::copysign(2 * std::numbers::pi * turning.turns, turning.speed) * static_cast<double>(k) /
               static_cast<double>(moments);
  const results::Harmonic harmonic(angle, order);
  OrderMatrices matrices{MatrixX::Zero(series.components, series.rows.cols()),
                         MatrixX::Zero(series.components, series.rows.cols())};
  const double weight = 2 / static_cast<double>(moments);
  for (Eigen::Index k = 0; k < moments; ++k) {
    const auto rows = series.rows.middleRows(k * stride * series.components, series.components);
    matrices.cosine += weight * harmonic.cosine[k] * rows;
    matrices.sine += weight * harmonic.sine[k] * rows;
  }
  return matrices;
}

CostFunction make_order_cost(const OrderMatrices& matrices, results::OrderPart part) {
  const auto shared = std::make_shared<const OrderMatrices>(matrices);
  const auto norms = std::make_shared<const std::vector<MatrixX>>(list_norms(matrices, part));
  return [shared, norms](const VectorX& parameters, VectorX* gradient) {
    if (parameters.size() != shared->cosine.cols() - 1)
      throw std::invalid_argument("not as many values as there are parameters");
    return norms->empty() ? largest_singular_value(*shared, parameters, gradient)
                          : sum_norms(*norms, parameters, gradient);
  };
}

std::vector<AffineFigure> make_order_figures(const OrderMatrices& matrices, results::OrderPart part, double weight) {
  std::vector<AffineFigure> figures;
  for (MatrixX& rows : list_norms(matrices, part))
    figures.push_back({weight, {}, Statistic::rms, {make_series(std::move(rows), 2, 1)}});
  if (!figures.empty()) return figures;
  const Eigen::Index components = matrices.cosine.rows();
  MatrixX rows(phase_count * components, matrices.cosine.cols());
  for (Eigen::Index k = 0; k < phase_count; ++k) {
    const double phase = std::numbers::pi * static_cast<double>(k) / static_cast<double>(phase_count);
    rows.middleRows(k * components, components) =
        elementary::cos(phase) * matrices.cosine + elementary::sin(phase) * matrices.sine;
  }
  figures.push_back({weight, {}, Statistic::peak, {make_series(std::move(rows), components, phase_count)}});
  return figures;
}

}  // namespace balance::design
