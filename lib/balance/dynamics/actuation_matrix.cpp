// How well the actuators hold a mechanism: closures and actuated coordinates as one matrix.

#include "balance/dynamics/actuation.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/base/number.hpp"

#include <algorithm>

namespace balance {

template <class S>
auto Actuation<S>::closure_jacobian(const KinematicEquations<S>& equations) const -> Matrix {
  Matrix closures(closures_, columns_);
  for (int r = 0; r < closures_; ++r)
    for (int c = 0; c < columns_; ++c) closures(r, c) = equations.entry(r, c);
  return closures;
}

/// Scaled tree coordinates to actuated ones, scaled too: the least norm of efforts then is the same in all units, forces
/// counted as moments on the characteristic length.
template <class S>
auto Actuation<S>::actuation_selection(const KinematicEquations<S>& equations) const -> Matrix {
  Matrix selection = Matrix::Zero(static_cast<Eigen::Index>(actuated_.size()), columns_);
  const std::vector<double>& scale = equations.column_scale();
  for (std::size_t a = 0; a < actuated_.size(); ++a) {
    const ActuatedCoordinate& motor = actuated_[a];
    const auto row = static_cast<Eigen::Index>(a);
    selection(row, motor.column) = motor.ratio * scale[motor.column] / motor.unit;
    for (const auto& [column, ratio] : motor.more) selection(row, column) = ratio * scale[column] / motor.unit;
  }
  return selection;
}

template <class S>
VectorX Actuation<S>::singular_values_without(std::size_t actuator, const KinematicEquations<S>& equations) const {
  MatrixX matrix = actuation_matrix(equations);
  matrix.row(closures_ + static_cast<Eigen::Index>(actuator)).setZero();
  return singular_values(matrix);
}

template <class S>
MatrixX Actuation<S>::actuation_matrix(const KinematicEquations<S>& equations) const {
  MatrixX matrix(closures_ + static_cast<Eigen::Index>(actuated_.size()), columns_);
  matrix << values_of(closure_jacobian(equations)), values_of(actuation_selection(equations));
  return matrix;
}

/// The places of actuation_matrix() that are not zero, of a large mechanism.
template <class S>
void Actuation<S>::prepare_actuation_matrix() {
  SparsityPattern pattern(static_cast<std::size_t>(columns_));
  for (const ClosureEntry& entry : closure_entries_) pattern[entry.row].push_back(entry.column);
  for (const std::vector<ClosureEntry>& column : motor_column_entries_)
    for (const ClosureEntry& entry : column) pattern[entry.row].push_back(entry.column);
  for (std::size_t a = 0; a < actuated_.size(); ++a) pattern[closures_ + a].push_back(actuated_[a].column);
  for (std::vector<int>& row : pattern) std::sort(row.begin(), row.end());
  has_sparse_matrix_ = sparse_matrix_.analyse(pattern);
}

template <class S>
std::optional<double> Actuation<S>::sparse_mobility(const KinematicEquations<S>& equations) const {
  BlockTriangular factors = sparse_matrix_;
  for (const ClosureEntry& entry : closure_entries_)
    factors.at(entry.row, entry.column) = value_of(equations.entry(entry.row, entry.column));
  for (const std::vector<ClosureEntry>& column : motor_column_entries_)
    for (const ClosureEntry& entry : column)
      factors.at(entry.row, entry.column) = value_of(equations.entry(entry.row, entry.column));
  for (std::size_t a = 0; a < actuated_.size(); ++a)
    factors.at(closures_ + static_cast<int>(a), actuated_[a].column) =
        value_of(actuated_[a].ratio) * equations.column_scale()[actuated_[a].column] / actuated_[a].unit;
  return factors.factorise() > 0 ? min_singular_value_by_lanczos(factors) : std::nullopt;
}

template <class S>
double Actuation<S>::mobility(const KinematicEquations<S>& equations) const {
  if (closures_ == 0) return 1;
  if (has_sparse_matrix_)
    if (const std::optional<double> value = sparse_mobility(equations)) return *value;
  return smallest_singular_value(actuation_matrix(equations));
}

using OnPlane = Actuation<PlanarOf<EngineScalar>>;
using InSpace = Actuation<SpatialOf<EngineScalar>>;
template OnPlane::Matrix OnPlane::closure_jacobian(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template InSpace::Matrix InSpace::closure_jacobian(const KinematicEquations<SpatialOf<EngineScalar>>&) const;
template OnPlane::Matrix OnPlane::selection(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template InSpace::Matrix InSpace::selection(const KinematicEquations<SpatialOf<EngineScalar>>&) const;
template MatrixX OnPlane::actuation_matrix(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template MatrixX InSpace::actuation_matrix(const KinematicEquations<SpatialOf<EngineScalar>>&) const;
template VectorX OnPlane::singular_values_without(std::size_t, const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template VectorX InSpace::singular_values_without(std::size_t,
                                                  const KinematicEquations<SpatialOf<EngineScalar>>&) const;
template void OnPlane::prepare_actuation_matrix();
template void InSpace::prepare_actuation_matrix();
template std::optional<double> OnPlane::sparse_mobility(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template std::optional<double> InSpace::sparse_mobility(const KinematicEquations<SpatialOf<EngineScalar>>&) const;
template double OnPlane::mobility(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template double InSpace::mobility(const KinematicEquations<SpatialOf<EngineScalar>>&) const;

}  // namespace balance
