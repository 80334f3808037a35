// How well the actuators hold a mechanism: closures and actuated coordinates as one matrix.

#include "balance/dynamics/actuation.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/base/number.hpp"

#include <algorithm>

namespace balance {

template <class S>
auto Actuation<S>::closure_matrix(const Equations<S>& equations) const -> Matrix {
  Matrix closures(closures_, columns_);
  for (int r = 0; r < closures_; ++r)
    for (int c = 0; c < columns_; ++c) closures(r, c) = equations.entry(r, c);
  return closures;
}

/// Scaled tree coordinates to actuated ones, scaled too: the least norm of efforts then is the same in all units, forces
/// counted as moments on the characteristic length.
template <class S>
auto Actuation<S>::selection(const Equations<S>& equations) const -> Matrix {
  Matrix selection = Matrix::Zero(static_cast<Eigen::Index>(actuated_.size()), columns_);
  const std::vector<double>& scale = equations.column_scale();
  for (std::size_t a = 0; a < actuated_.size(); ++a) {
    const Selected& motor = actuated_[a];
    const auto row = static_cast<Eigen::Index>(a);
    selection(row, motor.column) = motor.ratio * scale[motor.column] / motor.unit;
    for (const auto& [column, ratio] : motor.more) selection(row, column) = ratio * scale[column] / motor.unit;
  }
  return selection;
}

template <class S>
VectorX Actuation<S>::strengths_without(std::size_t actuator, const Equations<S>& equations) const {
  MatrixX matrix = actuation_matrix(equations);
  matrix.row(closures_ + static_cast<Eigen::Index>(actuator)).setZero();
  return singular_values(matrix);
}

template <class S>
MatrixX Actuation<S>::actuation_matrix(const Equations<S>& equations) const {
  MatrixX matrix(closures_ + static_cast<Eigen::Index>(actuated_.size()), columns_);
  matrix << values_of(closure_matrix(equations)), values_of(selection(equations));
  return matrix;
}

/// The places of actuation_matrix() that are not zero, of a large mechanism.
template <class S>
void Actuation<S>::prepare_actuation_matrix() {
  SparsityPattern pattern(static_cast<std::size_t>(columns_));
  for (const Gathered& entry : gathered_) pattern[entry.row].push_back(entry.column);
  for (const std::vector<Gathered>& column : at_motor_)
    for (const Gathered& entry : column) pattern[entry.row].push_back(entry.column);
  for (std::size_t a = 0; a < actuated_.size(); ++a) pattern[closures_ + a].push_back(actuated_[a].column);
  for (std::vector<int>& row : pattern) std::sort(row.begin(), row.end());
  has_sparse_matrix_ = sparse_matrix_.analyse(pattern);
}

template <class S>
std::optional<double> Actuation<S>::sparse_mobility(const Equations<S>& equations) const {
  BlockTriangular factors = sparse_matrix_;
  for (const Gathered& entry : gathered_)
    factors.at(entry.row, entry.column) = value_of(equations.entry(entry.row, entry.column));
  for (const std::vector<Gathered>& column : at_motor_)
    for (const Gathered& entry : column)
      factors.at(entry.row, entry.column) = value_of(equations.entry(entry.row, entry.column));
  for (std::size_t a = 0; a < actuated_.size(); ++a)
    factors.at(closures_ + static_cast<int>(a), actuated_[a].column) =
        value_of(actuated_[a].ratio) * equations.column_scale()[actuated_[a].column] / actuated_[a].unit;
  return factors.factorise() > 0 ? least_singular_by_inverse(factors) : std::nullopt;
}

template <class S>
double Actuation<S>::mobility(const Equations<S>& equations) const {
  if (closures_ == 0) return 1;
  if (has_sparse_matrix_)
    if (const std::optional<double> value = sparse_mobility(equations)) return *value;
  return smallest_singular_value(actuation_matrix(equations));
}

using OnPlane = Actuation<PlanarOf<Number>>;
using InSpace = Actuation<SpatialOf<Number>>;
template OnPlane::Matrix OnPlane::closure_matrix(const Equations<PlanarOf<Number>>&) const;
template InSpace::Matrix InSpace::closure_matrix(const Equations<SpatialOf<Number>>&) const;
template OnPlane::Matrix OnPlane::selection(const Equations<PlanarOf<Number>>&) const;
template InSpace::Matrix InSpace::selection(const Equations<SpatialOf<Number>>&) const;
template MatrixX OnPlane::actuation_matrix(const Equations<PlanarOf<Number>>&) const;
template MatrixX InSpace::actuation_matrix(const Equations<SpatialOf<Number>>&) const;
template VectorX OnPlane::strengths_without(std::size_t, const Equations<PlanarOf<Number>>&) const;
template VectorX InSpace::strengths_without(std::size_t, const Equations<SpatialOf<Number>>&) const;
template void OnPlane::prepare_actuation_matrix();
template void InSpace::prepare_actuation_matrix();
template std::optional<double> OnPlane::sparse_mobility(const Equations<PlanarOf<Number>>&) const;
template std::optional<double> InSpace::sparse_mobility(const Equations<SpatialOf<Number>>&) const;
template double OnPlane::mobility(const Equations<PlanarOf<Number>>&) const;
template double InSpace::mobility(const Equations<SpatialOf<Number>>&) const;

}  // namespace balance
