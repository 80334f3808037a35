#include "balance/synthesis/identification/base_combinations.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace balance::identification {

namespace {

/// A column of norm 1 is dependent if at most this much of it is left.
constexpr double independence_threshold = 1e-7;
/// Factors below this, between columns of norm 1, are round-off.
constexpr double factor_tolerance = 1e-8;

/// Orthogonalises columns against those chosen, by modified Gram–Schmidt with a second pass.
class ColumnChooser {
 public:
  explicit ColumnChooser(const MatrixX& matrix) : rest_(matrix) {
    for (Eigen::Index c = 0; c < rest_.cols(); ++c)
      if (const double norm = rest_.col(c).norm(); norm > 0) rest_.col(c) /= norm;
  }
  double remaining_norm(int column) const { return rest_.col(column).norm(); }
  void choose(int column) {
    VectorX direction = rest_.col(column);
    for (const VectorX& chosen : basis_) direction -= chosen.dot(direction) * chosen;
    const double norm = direction.norm();
    if (!(norm > 0)) return;
    basis_.push_back(direction / norm);
    for (int pass = 0; pass < 2; ++pass) rest_ -= basis_.back() * (basis_.back().transpose() * rest_).eval();
  }

 private:
  MatrixX rest_;
  std::vector<VectorX> basis_;
};

/// Adds columns in the order of their groups while some are independent.
void choose_columns(ColumnChooser& chooser, const std::vector<int>& groups, std::vector<int>& chosen) {
  const int last_group = groups.empty() ? -1 : *std::max_element(groups.begin(), groups.end());
  for (int group = 0; group <= last_group; ++group)
    for (;;) {
      int best = -1;
      double best_norm = independence_threshold;
      for (std::size_t c = 0; c < groups.size(); ++c) {
        const int column = static_cast<int>(c);
        if (groups[c] != group || std::find(chosen.begin(), chosen.end(), column) != chosen.end()) continue;
        if (const double norm = chooser.remaining_norm(column); norm > best_norm) best_norm = norm, best = column;
      }
      if (best < 0) break;
      chooser.choose(best);
      chosen.push_back(best);
    }
}

/// K with A_B K = A_R.
MatrixX solve_factors(const MatrixX& base, const MatrixX& rest) {
  const VectorX base_norms = base.colwise().norm(), rest_norms = rest.colwise().norm();
  MatrixX scaled = base;
  for (Eigen::Index c = 0; c < base.cols(); ++c) scaled.col(c) /= base_norms[c];
  MatrixX factors = numerics::ColumnPivotingQr(scaled).solve(rest);
  for (Eigen::Index i = 0; i < factors.rows(); ++i)
    for (Eigen::Index j = 0; j < factors.cols(); ++j) {
      if (std::abs(factors(i, j)) <= factor_tolerance * rest_norms[j]) factors(i, j) = 0;
      factors(i, j) /= base_norms[i];
    }
  return factors;
}

}  // namespace

VectorX BaseCombinations::evaluate(const VectorX& x) const {
  VectorX values(rank());
  for (Eigen::Index i = 0; i < rank(); ++i) {
    values[i] = x[base[static_cast<std::size_t>(i)]];
    for (std::size_t j = 0; j < rest.size(); ++j) values[i] += factors(i, static_cast<Eigen::Index>(j)) * x[rest[j]];
  }
  return values;
}

BaseCombinations find_base_combinations(const MatrixX& measured, const MatrixX& random,
                                        const std::vector<int>& groups) {
  BaseCombinations out;
  if (measured.rows() > 0) {
    ColumnChooser chooser(measured);
    choose_columns(chooser, groups, out.base);
  }
  // The random rows have the mechanism's rank: they drop what only round-off chose, and add what the motion left out.
  ColumnChooser chooser(random);
  std::vector<int> confirmed;
  for (const int column : out.base) {
    if (chooser.remaining_norm(column) <= independence_threshold) continue;
    chooser.choose(column);
    confirmed.push_back(column);
  }
  out.base = std::move(confirmed);
  choose_columns(chooser, groups, out.base);
  for (int c = 0; c < static_cast<int>(groups.size()); ++c)
    if (std::find(out.base.begin(), out.base.end(), c) == out.base.end()) out.rest.push_back(c);
  std::sort(out.base.begin(), out.base.end());
  out.factors = solve_factors(random(Eigen::all, out.base), random(Eigen::all, out.rest));
  return out;
}

MatrixX find_missing_combinations(const MatrixX& rows, const BaseCombinations& base, const std::vector<int>& groups) {
  const auto R = static_cast<Eigen::Index>(base.rest.size());
  const MatrixX rest = rows(Eigen::all, base.rest), known = rows(Eigen::all, base.base);
  MatrixX residual = rest - known * base.factors;
  const MatrixX terms = rest.cwiseAbs() + known.cwiseAbs() * base.factors.cwiseAbs();
  const double largest = negligible_column * numerics::max_abs(VectorX(terms.colwise().norm()));
  std::vector<int> rest_groups;
  for (Eigen::Index c = 0; c < R; ++c) {
    rest_groups.push_back(groups[static_cast<std::size_t>(base.rest[static_cast<std::size_t>(c)])]);
    if (residual.col(c).norm() <= std::max(independence_threshold * terms.col(c).norm(), largest))
      residual.col(c).setZero();
  }
  std::vector<int> chosen;
  ColumnChooser chooser(residual);
  choose_columns(chooser, rest_groups, chosen);
  MatrixX combinations = MatrixX::Zero(static_cast<Eigen::Index>(chosen.size()), rows.cols());
  if (chosen.empty()) return combinations;
  std::sort(chosen.begin(), chosen.end());
  const MatrixX factors = solve_factors(residual(Eigen::all, chosen), residual);
  for (Eigen::Index c = 0; c < R; ++c) combinations.col(base.rest[static_cast<std::size_t>(c)]) = factors.col(c);
  return combinations;
}

}  // namespace balance::identification
