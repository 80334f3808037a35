#include "balance/synthesis/conditions/row_reduction.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/right_singular_vectors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace balance::conditions {

using dynamics::ParameterKind;

namespace {

constexpr double min_singular_value_gap = 1e3;             ///< between the singular values kept and those dropped
constexpr double dropped_singular_value_threshold = 1e-8;  ///< relative to the largest: nothing above it is dropped
constexpr double kept_singular_value_threshold = 1e-9;     ///< nothing below it is kept
/// Minimum magnitude of a pivot in a unit row. The smaller ones apply only if there are no other pivots.
constexpr double pivot_thresholds[] = {1e-4, 1e-6, 0};
constexpr double elimination_tolerance = 1e-10;  ///< relative to the largest entry before elimination
/// Relative to the magnitude of an order's quantity: up to the first a row is round-off, from the second on it is none.
constexpr double order_round_off = 2e-12, min_order_size = 2e-11;
constexpr double row_entry_tolerance = 1e-10;  ///< relative to a reduced row's largest entry: smaller ones are zero

/// Number of joints between each body and the ground.
std::vector<int> joint_depths(const Mechanism& mechanism) {
  std::vector<int> depth(mechanism.bodies.size(), -1);
  depth[model::ground] = 0;
  std::queue<int> pending({model::ground});
  for (; !pending.empty(); pending.pop()) {
    const BodyId body = pending.front();
    for (const Joint& joint : mechanism.joints) {
      const int other = joint.first == body ? joint.second : joint.second == body ? joint.first : body;
      if (depth[static_cast<std::size_t>(other)] >= 0) continue;
      depth[static_cast<std::size_t>(other)] = depth[static_cast<std::size_t>(body)] + 1;
      pending.push(other);
    }
  }
  return depth;
}

/// Masses cannot be chosen freely; springs are additions.
int pivot_priority(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::mass: return 1;
    case ParameterKind::stiffness:
    case ParameterKind::stiffness_moment: return 2;
    case ParameterKind::force:
    case ParameterKind::couple:
    case ParameterKind::viscous:
    case ParameterKind::coulomb:
    case ParameterKind::tabulated: return 3;
    default: return 0;
  }
}

/// Number of singular values above the widest gap; −1 if the gap is too narrow.
int find_rank_by_gap(const VectorX& values, double min_value, Conditions& conditions) {
  int rank = -1;
  double widest = 0;
  const auto relative_value = [&](Eigen::Index i) {
    return i < values.size() ? std::max(values[i] / values[0], min_value) : min_value;
  };
  for (Eigen::Index r = 1; r <= values.size(); ++r) {
    const double kept = relative_value(r - 1), dropped = relative_value(r);
    if (kept < kept_singular_value_threshold || dropped > dropped_singular_value_threshold || kept / dropped <= widest)
      continue;
    widest = kept / dropped;
    rank = static_cast<int>(r);
    conditions.min_kept_singular_value = kept;
    conditions.max_dropped_singular_value = dropped;
  }
  conditions.singular_value_gap = widest;
  return widest > min_singular_value_gap ? rank : -1;
}

/// An orthonormal basis of the part of the row space in which a column is zero: one row fewer.
MatrixX eliminate_column(MatrixX rows, int column) {
  constexpr Eigen::Index min_rows_for_reflection = 48;
  if (rows.rows() >
      min_rows_for_reflection) {  // one reflection zeroes the column except its first entry; rows stay orthonormal
    VectorX householder_vector = rows.col(column);
    householder_vector[0] += std::copysign(householder_vector.norm(), householder_vector[0]);
    const Eigen::RowVectorXd projection =
        (2 / householder_vector.squaredNorm()) * (householder_vector.transpose() * rows);
    return rows.bottomRows(rows.rows() - 1) - householder_vector.tail(rows.rows() - 1) * projection;
  }
  rows.row(0).swap(rows.row(numerics::max_index(rows.col(column).cwiseAbs())));
  const VectorX multipliers = rows.col(column).tail(rows.rows() - 1) / rows(0, column);
  const MatrixX remaining = rows.bottomRows(rows.rows() - 1) - multipliers * rows.row(0);
  if (remaining.rows() == 0) return remaining;
  // orthonormalise again: the rows keep unit norm, so that small entries stay small
  const Eigen::HouseholderQR<MatrixX> qr(remaining.transpose());
  return (qr.householderQ() * MatrixX::Identity(remaining.cols(), remaining.rows())).transpose();
}

/// Columns for which the rows can be solved, in order of preference. The rows must be orthonormal.
std::vector<int> choose_pivots(MatrixX rows, const std::vector<int>& order) {
  std::vector<int> pivots;
  std::vector<bool> is_pivot(order.size(), false);
  for (const double threshold : pivot_thresholds)
    for (const int column : order) {
      if (rows.rows() == 0) return pivots;
      if (is_pivot[static_cast<std::size_t>(column)]) continue;
      if (!(numerics::max_abs(rows.col(column)) > threshold)) continue;
      is_pivot[static_cast<std::size_t>(column)] = true;
      pivots.push_back(column);
      rows = eliminate_column(std::move(rows), column);
      for (const int pivot : pivots) rows.col(pivot).setZero();
    }
  return pivots;
}

/// Solves the orthonormal rows for all pivots at once, so that errors do not grow from pivot to pivot.
void compute_echelon_form(MatrixX& rows, const std::vector<int>& pivots) {
  const MatrixX solved = MatrixX(rows(Eigen::all, pivots)).fullPivLu().solve(rows);
  rows = solved;
  for (std::size_t r = 0; r < pivots.size(); ++r)
    rows.col(pivots[r]) = VectorX::Unit(rows.rows(), static_cast<Eigen::Index>(r));
}

}  // namespace

std::vector<int> order_pivots(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters) {
  const std::vector<int> depth = joint_depths(mechanism);
  std::vector<int> order(parameters.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int p) {
    const dynamics::Parameter& parameter = parameters[static_cast<std::size_t>(p)];
    const bool is_body = parameter.owner_kind == dynamics::ParameterOwner::body;
    return std::tuple(pivot_priority(parameter.kind), parameter.owner_kind,
                      is_body ? depth[static_cast<std::size_t>(parameter.index)] : 0, parameter.index, parameter.slot);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  return order;
}

MatrixX eliminate_extra_unknowns(const MatrixX& rows, int parameters) {
  const Eigen::Index extra = rows.cols() - parameters;
  if (extra == 0 || rows.rows() == 0) return rows;
  numerics::ColumnPivotingQr qr(rows.rightCols(extra));
  qr.setThreshold(1e-9);
  MatrixX rotated = rows.leftCols(parameters);
  const double magnitude = numerics::max_abs(rotated);
  rotated.applyOnTheLeft(qr.householderQ().adjoint());
  MatrixX reduced = rotated.bottomRows(rows.rows() - qr.rank());
  // On a single link, tool and CoM move together whatever the parameters: round-off is not a condition.
  if (numerics::max_abs(reduced) < elimination_tolerance * magnitude) reduced.setZero();
  return reduced;
}

MatrixX scale_order_rows(const OrderRows& orders, const VectorX& units, const VectorX& mask) {
  MatrixX rows(static_cast<Eigen::Index>(orders.rows.size()), units.size());
  for (std::size_t r = 0; r < orders.rows.size(); ++r) {
    const OrderRow& order = orders.rows[r];
    const double scale = order.magnitude > 0 ? 1 / order.magnitude : 0;
    rows.row(static_cast<Eigen::Index>(r)) =
        scale * order.coefficients.cwiseProduct(units).cwiseProduct(mask).transpose();
  }
  return rows;
}

std::optional<OrderRemainder> add_order_rows(const MatrixX& rows, MatrixX& basis) {
  MatrixX rest = rows;
  for (int k = 0; k < 2 && basis.rows() > 0; ++k) rest -= rest * basis.transpose() * basis;
  // The largest remainder first: then no remainder along a new direction exceeds that from which the direction comes, and
  // the direction's error does not grow in it.
  while (rest.rows() > 0) {
    const VectorX sizes = rest.rowwise().norm();
    const Eigen::Index r = numerics::max_index(sizes);
    if (sizes[r] <= order_round_off) break;
    if (sizes[r] < min_order_size) return OrderRemainder{r, sizes[r]};
    VectorX direction = rest.row(r).transpose();
    if (basis.rows() > 0) direction -= basis.transpose() * (basis * direction);
    direction.normalize();
    basis.conservativeResize(basis.rows() + 1, rows.cols());
    basis.row(basis.rows() - 1) = direction.transpose();
    rest -= (rest * direction) * direction.transpose();
  }
  return std::nullopt;
}

MatrixX condition_basis(const Conditions& conditions, const VectorX& units) {
  if (conditions.matrix.rows() == 0) return MatrixX(0, units.size());
  MatrixX rows = conditions.matrix * units.asDiagonal();
  for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
  const Eigen::HouseholderQR<MatrixX> qr(rows.transpose());
  return (qr.householderQ() * MatrixX::Identity(rows.cols(), rows.rows())).transpose();
}

bool reduce_conditions(const MatrixX& rows, const VectorX& units, double mass, const std::vector<int>& order,
                       Conditions& conditions) {
  const Eigen::Index P = units.size();
  conditions.rank = 0;
  conditions.matrix.resize(0, P);
  conditions.row_scales.resize(0);
  conditions.pivots.clear();
  conditions.singular_value_gap = 1 / std::numeric_limits<double>::epsilon();
  if (numerics::max_abs(rows) == 0) return true;
  if (!rows.allFinite()) return false;

  MatrixX compact = rows;
  if (rows.rows() > P) {
    const Eigen::HouseholderQR<MatrixX> qr(rows);
    compact = qr.matrixQR().topRows(P).template triangularView<Eigen::Upper>();
  }
  const numerics::RightSingularVectors svd = numerics::compute_right_singular_vectors(compact);
  const int rank = find_rank_by_gap(svd.values, std::numeric_limits<double>::epsilon(), conditions);
  if (rank < 0 || !svd.values.allFinite() || !svd.vectors.allFinite()) return false;

  MatrixX reduced = svd.vectors.leftCols(rank).transpose();
  conditions.pivots = choose_pivots(reduced, order);
  if (static_cast<int>(conditions.pivots.size()) != rank) return false;
  compute_echelon_form(reduced, conditions.pivots);
  conditions.rank = rank;
  conditions.matrix.resize(rank, P);
  conditions.row_scales.resize(rank);
  for (Eigen::Index r = 0; r < rank; ++r) {
    const double largest = numerics::max_abs(reduced.row(r));
    for (Eigen::Index p = 0; p < P; ++p)
      if (std::abs(reduced(r, p)) < row_entry_tolerance * largest) reduced(r, p) = 0;
    const double pivot = units[conditions.pivots[static_cast<std::size_t>(r)]];
    conditions.matrix.row(r) = reduced.row(r).cwiseQuotient(units.transpose()) * pivot;
    conditions.matrix(r, conditions.pivots[static_cast<std::size_t>(r)]) = 1;  // units cancel up to round-off
    conditions.row_scales[r] = mass * pivot * largest;
  }
  return true;
}

}  // namespace balance::conditions
