#include "balance/synthesis/identification/estimation.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::identification {

namespace {

constexpr int max_reweighting_steps = 40;
constexpr double reweighting_tolerance = 1e-6;  ///< largest relative change of the rms of a channel's residual
/// Noise of a channel is at least this part of what it measures: exact data have finite weights.
constexpr double min_relative_residual = 1e-9;

}  // namespace

CompressedChannel::CompressedChannel(const std::vector<Channel>& channels, std::size_t channel) {
  const Channel& own = channels[channel];
  unknowns_ = own.pieces.front().columns.cols();
  const auto C = static_cast<Eigen::Index>(channels.size());
  rows_ = own.count(&ChannelPiece::is_fitted);
  MatrixX stacked(rows_, unknowns_ + 1 + C);
  Eigen::Index next = 0;
  for (std::size_t p = 0; p < own.pieces.size(); ++p) {
    const ChannelPiece& piece = own.pieces[p];
    for (Eigen::Index k = 0; k < piece.measured.size(); ++k) {
      if (!piece.is_fitted[static_cast<std::size_t>(k)]) continue;
      stacked.row(next).head(unknowns_) = piece.columns.row(k);
      stacked(next, unknowns_) = piece.known[k];
      for (Eigen::Index c = 0; c < C; ++c)
        stacked(next, unknowns_ + 1 + c) = channels[static_cast<std::size_t>(c)].pieces[p].measured[k];
      ++next;
    }
  }
  if (rows_ <= stacked.cols()) {
    factor_ = std::move(stacked);
    return;
  }
  const Eigen::HouseholderQR<MatrixX> qr(stacked);
  factor_ = qr.matrixQR().topRows(stacked.cols()).triangularView<Eigen::Upper>();
}

std::vector<CompressedChannel> compress(const std::vector<Channel>& channels) {
  std::vector<CompressedChannel> compressed;
  for (std::size_t c = 0; c < channels.size(); ++c) compressed.emplace_back(channels, c);
  return compressed;
}

MatrixX base_columns(const MatrixX& columns, const BaseCombinations& base) { return columns(Eigen::all, base.base); }

namespace {

/// The shortest least-squares step along what the columns show.
struct ExcitedSolution {
  VectorX step;  ///< per column
  Eigen::Index rank = 0;
  double condition = 0;              ///< of the columns at norm 1, along what they show
  std::vector<double> hidden_share;  ///< of each column, in what they do not show: 0 to 1
  std::vector<bool> is_found;        ///< per column
};

ExcitedSolution solve_excited(const MatrixX& A, const VectorX& b) {
  VectorX scale = A.colwise().norm();
  for (double& one : scale) one = one > 0 ? 1 / one : 0;  // columns that are zero stay so
  const MatrixX scaled = A * scale.asDiagonal();
  const numerics::SymmetricEigenSolver eigen(MatrixX(scaled.transpose() * scaled));
  const VectorX sigma = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();  // increasing
  const double largest = numerics::max_abs(sigma);
  Eigen::Index hidden_count = 0;
  while (hidden_count < A.cols() && !(sigma[hidden_count] > excitation_threshold * largest)) ++hidden_count;
  ExcitedSolution solution;
  solution.rank = A.cols() - hidden_count;
  if (solution.rank > 0) solution.condition = largest / sigma[hidden_count];
  const MatrixX shown = eigen.eigenvectors().rightCols(solution.rank);
  const VectorX inverse = sigma.tail(solution.rank).cwiseAbs2().cwiseInverse();
  solution.step = scale.cwiseProduct(shown * inverse.cwiseProduct(shown.transpose() * (scaled.transpose() * b)));
  for (Eigen::Index k = 0; k < A.cols(); ++k) {
    solution.hidden_share.push_back(eigen.eigenvectors().row(k).head(hidden_count).squaredNorm());
    solution.is_found.push_back(scale[k] > 0 && solution.hidden_share.back() <= hidden_share_tolerance);
  }
  return solution;
}

}  // namespace

Estimate estimate(const std::vector<Channel>& channels, const std::vector<CompressedChannel>& compressed,
                  const BaseCombinations& base, const VectorX& spec, const std::vector<std::optional<double>>& gains,
                  const std::vector<Reading>& given_readings) {
  const std::size_t C = channels.size();
  const auto count = static_cast<Eigen::Index>(C);
  std::vector<Reading> readings = given_readings;
  for (std::size_t c = readings.size(); c < C; ++c) readings.push_back({c, 1});
  Estimate out;
  out.beta = base.evaluate(spec);
  out.kappa.setOnes(count);
  out.residual_rms.setOnes(count);
  std::vector<MatrixX> columns;
  std::vector<VectorX> known, measured;
  std::vector<std::size_t> unknown_gains;
  for (std::size_t c = 0; c < C; ++c) {
    columns.push_back(base_columns(compressed[c].columns(), base));
    known.emplace_back(compressed[c].known());
    measured.emplace_back(readings[c].factor * compressed[c].measured(readings[c].source));
    const auto i = static_cast<Eigen::Index>(c);
    if (channels[c].is_current && gains[c]) out.kappa[i] = 1 / *gains[c];
    if (channels[c].is_current && !gains[c]) {
      unknown_gains.push_back(c);
      const VectorX effort = columns[c] * out.beta + known[c];
      out.kappa[i] = effort.squaredNorm() > 0 ? effort.dot(measured[c]) / effort.squaredNorm() : 1;
    }
    out.residual_rms[i] = std::max(measured[c].norm(), 1e-300);
  }
  const Eigen::Index B = base.rank(), G = static_cast<Eigen::Index>(unknown_gains.size());
  Eigen::Index total = 0;
  for (const MatrixX& block : columns) total += block.rows();
  MatrixX A(total, B + G);
  VectorX b(total);
  for (int step = 0; step < max_reweighting_steps; ++step) {
    A.setZero();
    Eigen::Index row = 0;
    for (std::size_t c = 0; c < C; ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const double weight = 1 / out.residual_rms[i];
      const Eigen::Index rows = columns[c].rows();
      A.block(row, 0, rows, B) = weight * out.kappa[i] * columns[c];
      b.segment(row, rows) = weight * (measured[c] - out.kappa[i] * (columns[c] * out.beta + known[c]));
      for (Eigen::Index g = 0; g < G; ++g)
        if (unknown_gains[static_cast<std::size_t>(g)] == c)
          A.block(row, B + g, rows, 1) = weight * (columns[c] * out.beta + known[c]);
      row += rows;
    }
    const ExcitedSolution solution = solve_excited(A, b);
    out.beta += solution.step.head(B);
    for (Eigen::Index g = 0; g < G; ++g)
      out.kappa[static_cast<Eigen::Index>(unknown_gains[static_cast<std::size_t>(g)])] += solution.step[B + g];
    out.rank = static_cast<int>(solution.rank);
    out.condition = solution.condition;
    out.found.assign(solution.is_found.begin(), solution.is_found.begin() + B);
    out.gains_are_ambiguous = std::any_of(solution.hidden_share.begin() + B, solution.hidden_share.end(),
                                          [](double share) { return share > hidden_share_tolerance; });
    double change = 0, sum = 0;
    for (std::size_t c = 0; c < C; ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const VectorX residual = out.kappa[i] * (columns[c] * out.beta + known[c]) - measured[c];
      const auto rows = static_cast<double>(std::max<Eigen::Index>(1, compressed[c].rows()));
      const double size_of = measured[c].norm() / std::sqrt(rows);
      const double residual_rms =
          std::max({residual.norm() / std::sqrt(rows), min_relative_residual * size_of, 1e-300});
      change = std::max(change, std::abs(residual_rms / out.residual_rms[i] - 1));
      out.residual_rms[i] = residual_rms;
      sum += size_of > 0 ? residual_rms * residual_rms / (size_of * size_of) : 0;
    }
    out.relative_residual = std::sqrt(sum / static_cast<double>(C));
    if (change <= reweighting_tolerance) break;
  }
  for (std::size_t c : unknown_gains)
    out.gains_are_ambiguous = out.gains_are_ambiguous || !(out.kappa[static_cast<Eigen::Index>(c)] > 0);
  return out;
}

MatrixX robust_covariance(const std::vector<Channel>& channels, const BaseCombinations& base, const Estimate& found,
                          const std::vector<std::optional<double>>& gains, double correlation_time) {
  std::vector<std::size_t> unknown_gains;
  for (std::size_t c = 0; c < channels.size(); ++c)
    if (channels[c].is_current && !gains[c]) unknown_gains.push_back(c);
  const Eigen::Index B = base.rank(), size = B + static_cast<Eigen::Index>(unknown_gains.size());
  MatrixX normal = MatrixX::Zero(size, size), meat = MatrixX::Zero(size, size);
  long rows = 0;
  for (std::size_t p = 0; p < channels.front().pieces.size(); ++p) {
    const Eigen::Index T = channels.front().pieces[p].measured.size();
    MatrixX scores = MatrixX::Zero(T, size);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const ChannelPiece& piece = channels[c].pieces[p];
      const MatrixX columns = base_columns(piece.columns, base);
      const VectorX effort = columns * found.beta + piece.known;
      MatrixX jacobian = MatrixX::Zero(T, size);
      jacobian.leftCols(B) = found.kappa[i] / found.residual_rms[i] * columns;
      for (std::size_t g = 0; g < unknown_gains.size(); ++g)
        if (unknown_gains[g] == c) jacobian.col(B + static_cast<Eigen::Index>(g)) = effort / found.residual_rms[i];
      VectorX residual = (piece.measured - found.kappa[i] * effort) / found.residual_rms[i];
      for (Eigen::Index k = 0; k < T; ++k)
        if (!piece.is_fitted[static_cast<std::size_t>(k)]) residual[k] = 0, jacobian.row(k).setZero();
      rows += std::count(piece.is_fitted.begin(), piece.is_fitted.end(), true);
      normal.noalias() += jacobian.transpose() * jacobian;
      scores += residual.asDiagonal() * jacobian;
    }
    // Bartlett weights 1 − l/L are those of the products of moving sums over L rows.
    const auto L = std::max<Eigen::Index>(
        1, static_cast<Eigen::Index>(std::round(correlation_time / channels.front().pieces[p].step)));
    MatrixX sums(T + L - 1, size);
    VectorX sum = VectorX::Zero(size);
    for (Eigen::Index k = 0; k < T + L - 1; ++k) {
      if (k < T) sum += scores.row(k).transpose();
      if (k >= L) sum -= scores.row(k - L).transpose();
      sums.row(k) = sum.transpose();
    }
    meat.noalias() += sums.transpose() * sums / static_cast<double>(L);
  }
  VectorX scale = normal.diagonal().cwiseSqrt();
  for (double& one : scale) one = one > 0 ? 1 / one : 0;
  const numerics::SymmetricEigenSolver eigen(MatrixX(scale.asDiagonal() * normal * scale.asDiagonal()));
  const VectorX& values = eigen.eigenvalues();
  VectorX inverse = values;
  const double threshold =
      excitation_threshold * excitation_threshold * std::max(numerics::max_coefficient(values), 0.0);
  for (double& one : inverse) one = one > threshold ? 1 / one : 0;
  const MatrixX pseudo_inverse = scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
                                 eigen.eigenvectors().transpose() * scale.asDiagonal();
  const double freedom = static_cast<double>(rows) / std::max(1.0, static_cast<double>(rows - size));
  return freedom * pseudo_inverse * meat * pseudo_inverse;
}

}  // namespace balance::identification
