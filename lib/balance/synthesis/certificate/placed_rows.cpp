#include "balance/synthesis/certificate/placed_rows.hpp"

#include <utility>

namespace balance::certificate {

ExpandedColumns expand(const BernsteinCoefficients& coefficients, const std::vector<int>& affine) {
  ExpandedColumns result{coefficients, {}};
  for (const int length : affine) result.plain.axis(length);
  const BernsteinCoefficients base = result.plain;
  for (const int length : affine) result.plain.elevate(result.plain.axis(length));
  for (const int factor : affine) {
    BernsteinCoefficients product = base;
    for (const int length : affine) {
      const std::size_t axis = product.axis(length);
      if (length == factor)
        product.multiply_by_centred(axis);
      else
        product.elevate(axis);
    }
    result.centred.push_back(std::move(product.values));
  }
  return result;
}

std::vector<Vector3> PlacedRows::list_corners() const {
  std::vector<Vector3> corners{lower};
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (lower[i] == upper[i]) continue;
    const std::size_t count = corners.size();
    for (std::size_t c = 0; c < count; ++c) {
      corners.push_back(corners[c]);
      corners.back()[i] = upper[i];
    }
  }
  return corners;
}

ExpandedColumns PlacedRows::at(const Vector3& place) const {
  const FunctionValues values = functions(place);
  const auto combine = [&](const MatrixX& all) {
    MatrixX combined = MatrixX::Zero(all.rows(), 1 + unknowns);
    combined.col(0) = all.col(0);
    for (Eigen::Index f = 0; f < place_functions; ++f)
      if (values[f] != 0) combined.rightCols(unknowns) += values[f] * all.middleCols(1 + f * unknowns, unknowns);
    return combined;
  };
  ExpandedColumns result{columns.plain, {}};
  result.plain.values = combine(columns.plain.values);
  result.plain.magnitudes.resize(1 + unknowns);
  result.plain.magnitudes << columns.plain.magnitudes[0], magnitudes(values.cwiseAbs());
  for (const MatrixX& centred : columns.centred) result.centred.push_back(combine(centred));
  return result;
}

VectorX PlacedRows::magnitudes() const {
  const Vector3 largest = lower.cwiseAbs().cwiseMax(upper.cwiseAbs());
  return magnitudes(functions(largest));
}

VectorX PlacedRows::magnitudes(const FunctionValues& values) const {
  VectorX sums = VectorX::Zero(unknowns);
  for (Eigen::Index f = 0; f < place_functions; ++f)
    sums += values[f] * columns.plain.magnitudes.segment(1 + f * unknowns, unknowns);
  return sums;
}

MatrixX PlacedRows::evaluate(const MatrixX& w) const {
  MatrixX result(columns.plain.values.rows(), place_functions);
  for (Eigen::Index f = 0; f < place_functions; ++f) {
    VectorX sum = columns.plain.values.middleCols(1 + f * unknowns, unknowns) * w.row(0).transpose();
    for (std::size_t part = 0; part < columns.centred.size(); ++part)
      sum += columns.centred[part].middleCols(1 + f * unknowns, unknowns) *
             w.row(static_cast<Eigen::Index>(part) + 1).transpose();
    result.col(f) = sum.cwiseQuotient(columns.plain.values.col(0));
  }
  return result;
}

HighestPlaces PlacedRows::find_highest(const MatrixX& w) const {
  const MatrixX values = evaluate(w);
  HighestPlaces result{values.col(0), std::vector<Vector3>(static_cast<std::size_t>(values.rows()), lower)};
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (numbers[static_cast<std::size_t>(i)] < 0) continue;
      const double slope = values(row, i < 2 ? 1 + i : 4), curvature = i < 2 ? values(row, 3) : 0;
      const auto height = [&](double at) { return at * (slope + curvature * at); };
      double best = height(lower[i]) >= height(upper[i]) ? lower[i] : upper[i];
      if (const double vertex = -slope / (2 * curvature); curvature < 0 && vertex > lower[i] && vertex < upper[i])
        best = vertex;
      result.places[static_cast<std::size_t>(row)][i] = best;
      result.heights[row] += height(best);
    }
  return result;
}

}  // namespace balance::certificate
