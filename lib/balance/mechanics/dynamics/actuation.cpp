#include "balance/mechanics/dynamics/actuation.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace balance::dynamics {

using kinematics::KinematicEquations;
using kinematics::PlanarOf;
using kinematics::SpatialOf;

template <class S>
Actuation<S>::Actuation(const MechanismOf<T>& mechanism, const kinematics::Tree<S>& tree, int freedoms)
    : columns_(tree.columns), closures_(tree.closure_rows), freedoms_(freedoms) {
  std::set<int> distinct;
  for (const CoordinateId coordinate : mechanism.actuators) {
    const kinematics::LinearQuantityOf<T>& source = tree.coordinate_expressions[coordinate];
    const auto& [column, ratio] = source.terms[0];
    actuated_.push_back({column,
                         ratio,
                         source.is_length ? tree.characteristic_length : 1,
                         {source.terms.begin() + 1, source.terms.end()}});
    if (source.has_single_term()) distinct.insert(column);
  }
  const int motors = static_cast<int>(actuated_.size());
  efforts_.assign(motors, 0);
  multipliers_.assign(closures_, 0);
  if (motors < freedoms) mismatch_ = trajectory::describe_under_actuation(motors, freedoms);
  trajectory::add_distribution_note(mechanism, freedoms, notes_);
  if (motors > freedoms && mechanism.torque_distribution)
    distribution_ = model::scale_distribution(mechanism, tree.characteristic_length);
  if (closures_ > columns_ - freedoms) notes_.push_back(trajectory::describe_over_constraint());
  const bool has_distinct_columns = static_cast<int>(distinct.size()) == motors;
  regular_ = motors == freedoms && has_distinct_columns && closures_ == columns_ - freedoms;
  if (regular_) prepare_regular(tree);
}

template <class S>
void Actuation<S>::prepare_regular(const kinematics::Tree<S>& tree) {
  std::vector<int> motor_of_column(columns_, -1), passive_index(columns_, -1);
  for (std::size_t a = 0; a < actuated_.size(); ++a) motor_of_column[actuated_[a].column] = static_cast<int>(a);
  for (int c = 0; c < columns_; ++c) {
    if (motor_of_column[c] >= 0) continue;
    passive_index[c] = static_cast<int>(passive_columns_.size());
    passive_columns_.push_back(c);
  }
  motor_column_entries_.resize(actuated_.size());
  numerics::SparsityPattern passive(static_cast<std::size_t>(closures_));
  int row = 0;
  for (const kinematics::Closure<S>& closure : tree.closures) {
    std::set<int> columns;
    for (const kinematics::PathStep& step : closure.path) columns.insert(tree.nodes[step.node].column);
    for (std::size_t r = 0; r < closure.rows.size(); ++r, ++row)
      for (const int c : columns) {
        if (motor_of_column[c] >= 0)
          motor_column_entries_[motor_of_column[c]].push_back({row, c});
        else
          passive[row].push_back(passive_index[c]);
      }
  }
  if (!passive_.analyse(passive)) {
    regular_ = false;
    return;
  }
  for (int r = 0; r < closures_; ++r)
    for (const int k : passive[r]) closure_entries_.push_back({r, passive_columns_[k], passive_.index(r, k)});
  if (columns_ > numerics::max_dense_columns) prepare_actuation_matrix();
}

template <class S>
bool Actuation<S>::solve(const KinematicEquations<S>& equations, const T* tau) {
  return regular_ ? solve_regular(equations, tau) : solve_general(equations, tau);
}

template <class S>
bool Actuation<S>::solve_regular(const KinematicEquations<S>& equations, const T* tau) {
  for (std::size_t a = 0; a < actuated_.size(); ++a) efforts_[a] = tau[actuated_[a].column] / actuated_[a].ratio;
  if (closures_ == 0) return true;
  if (factorise_passive(equations) < numerics::singular_pivot_threshold) return false;
  const std::vector<double>&columns = equations.column_scale(), &rows = equations.row_scale();
  for (int k = 0; k < closures_; ++k) multipliers_[k] = columns[passive_columns_[k]] * tau[passive_columns_[k]];
  passive_.solve_transposed(multipliers_.data());
  for (std::size_t a = 0; a < actuated_.size(); ++a) {
    T sum = 0;
    for (const ClosureEntry& entry : motor_column_entries_[a])
      sum += equations.entry_at(entry.storage_index) * multipliers_[entry.row];
    efforts_[a] -= sum / (columns[actuated_[a].column] * actuated_[a].ratio);
  }
  for (int r = 0; r < closures_; ++r) multipliers_[r] *= rows[r];
  return true;
}

/// Factorises the closures' passive columns at the present configuration.
template <class S>
double Actuation<S>::factorise_passive(const KinematicEquations<S>& equations) {
  if (factorised_equations_ == &equations && factorised_evaluation_ == equations.evaluation_count()) return regularity_;
  if (pattern_id_ != equations.pattern_id()) find_entry_indices(equations);
  for (const ClosureEntry& entry : closure_entries_)
    passive_.storage()[entry.index] = equations.entry_at(entry.storage_index);
  regularity_ = passive_.factorise();
  factorised_equations_ = &equations;
  factorised_evaluation_ = equations.evaluation_count();
  return regularity_;
}

template <class S>
void Actuation<S>::find_entry_indices(const KinematicEquations<S>& equations) {
  for (ClosureEntry& entry : closure_entries_) entry.storage_index = equations.entry_index(entry.row, entry.column);
  for (std::vector<ClosureEntry>& column : motor_column_entries_)
    for (ClosureEntry& entry : column) entry.storage_index = equations.entry_index(entry.row, entry.column);
  pattern_id_ = equations.pattern_id();
}

template <class S>
double Actuation<S>::factorise(const KinematicEquations<S>& equations) {
  if (closures_ == 0) return 1;
  if (regular_) return factorise_passive(equations);
  return matrix_.factorise(actuation_matrix(equations));
}

template <class S>
std::size_t Actuation<S>::redundant_count() const {
  return closures_ > 0 && static_cast<int>(actuated_.size()) > freedoms_ ? actuated_.size() : 0;
}

template <class S>
void Actuation<S>::store() {
  if (closures_ == 0) return;
  if (regular_)
    passive_.store();
  else
    matrix_.store();
}

template <class S>
bool Actuation<S>::is_near_stored(double limit) {
  if (closures_ == 0) return true;
  return regular_ ? passive_.is_near_stored(limit) : matrix_.is_near_stored(limit);
}

template <class S>
bool Actuation<S>::solve_general(const KinematicEquations<S>& equations, const T* tau) {
  const std::vector<double>&columns = equations.column_scale(), &rows = equations.row_scale();
  VectorXOf<T> f(columns_);
  for (int c = 0; c < columns_; ++c) f[c] = columns[c] * tau[c];
  Matrix actuated = actuation_selection(equations);
  const Matrix closures = closure_jacobian(equations);
  const MatrixX C_values = values_of(closures);
  const ActuationFactors factors(C_values, values_of(actuated), freedoms_);
  if (!factors.is_regular) return false;
  if (distribution_) scale_selection(actuated);
  const MatrixX S_values = values_of(actuated);
  const VectorX f_values = values_of(f);
  numerics::BoundedSolution bounded;
  LeastNormSolution solution;
  if (distribution_) {
    bounded = distribute_efforts(*distribution_, factors.null_space.transpose() * S_values.transpose(),
                                 factors.null_space.transpose() * f_values);
    solution = {bounded.x, solve_multipliers(factors, S_values, f_values, bounded.x)};
  } else {
    solution = solve_least_norm(factors, S_values, f_values);
  }
  for (std::size_t a = 0; a < efforts_.size(); ++a) efforts_[a] = solution.efforts[static_cast<Eigen::Index>(a)];
  for (int r = 0; r < closures_; ++r) multipliers_[r] = solution.multipliers[r];
  if constexpr (!std::is_same_v<T, double>) {
    for (std::size_t k = 0; k < T().d.size(); ++k) {
      std::vector<ActiveBoundChange> active;
      for (const numerics::ActiveBound& bound : bounded.active) active.push_back(bound_change(bound, k));
      const LeastNormSolution change =
          differentiate_least_norm(factors, solution, C_values, S_values, derivatives_of(closures, k),
                                   derivatives_of(actuated, k), derivatives_of(f, k), active, bounded.excess);
      for (std::size_t a = 0; a < efforts_.size(); ++a) efforts_[a].d[k] = change.efforts[static_cast<Eigen::Index>(a)];
      for (int r = 0; r < closures_; ++r) multipliers_[r].d[k] = change.multipliers[r];
    }
  }
  for (std::size_t a = 0; a < efforts_.size(); ++a) {
    if (distribution_)
      efforts_[a] = efforts_[a] / distribution_->unit[a];
    else
      efforts_[a] = efforts_[a] / actuated_[a].unit;
  }
  for (int r = 0; r < closures_; ++r) multipliers_[r] *= rows[r];
  return true;
}

/// Maps to scaled efforts of the distribution.
template <class S>
void Actuation<S>::scale_selection(Matrix& selection) const {
  for (std::size_t a = 0; a < actuated_.size(); ++a)
    for (int c = 0; c < columns_; ++c) selection(static_cast<Eigen::Index>(a), c) /= distribution_->factor[a];
}

template <class S>
ActiveBoundChange Actuation<S>::bound_change(const numerics::ActiveBound& bound, std::size_t k) const {
  using Kind = numerics::ActiveBound::Kind;
  const auto a = static_cast<std::size_t>(bound.index);
  ActiveBoundChange change{.actuator = bound.index};
  if (bound.kind == Kind::lowest_peak || bound.kind == Kind::highest_peak) {
    change.peak_share = bound.kind == Kind::highest_peak ? 1 : -1;
    return change;
  }
  const bool is_upper = bound.kind == Kind::upper;
  const double sign = is_upper ? 1 : -1;
  const T &limit = is_upper ? *distribution_->upper[a] : *distribution_->lower[a], &factor = distribution_->factor[a];
  change.excess_share = sign * value_of(factor);
  if constexpr (!std::is_same_v<T, double>) {
    change.bound_change = limit.d[k];
    change.excess_share_change = sign * factor.d[k];
  }
  return change;
}

template <class S>
bool Actuation<S>::project(const KinematicEquations<S>& equations, MatrixX& projection) {
  projection.setZero(static_cast<Eigen::Index>(actuated_.size()), columns_);
  return regular_ ? project_regular(equations, projection) : project_general(equations, projection);
}

/// solve_regular transposed: one system per actuator instead of one per generalised force.
template <class S>
bool Actuation<S>::project_regular(const KinematicEquations<S>& equations, MatrixX& projection) {
  if (closures_ > 0 && factorise_passive(equations) < numerics::singular_pivot_threshold) return false;
  const std::vector<double>& columns = equations.column_scale();
  std::vector<T> passive_rates(closures_);
  for (std::size_t a = 0; a < actuated_.size(); ++a) {
    const auto row = static_cast<Eigen::Index>(a);
    const ActuatedCoordinate& motor = actuated_[a];
    projection(row, motor.column) = 1 / value_of(motor.ratio);
    if (closures_ == 0) continue;
    std::fill(passive_rates.begin(), passive_rates.end(), T(0));
    for (const ClosureEntry& entry : motor_column_entries_[a])
      passive_rates[entry.row] = equations.entry_at(entry.storage_index) / (columns[motor.column] * motor.ratio);
    passive_.solve(passive_rates.data());
    for (int k = 0; k < closures_; ++k)
      projection(row, passive_columns_[k]) = -value_of(passive_rates[k]) * columns[passive_columns_[k]];
  }
  return true;
}

template <class S>
bool Actuation<S>::project_general(const KinematicEquations<S>& equations, MatrixX& projection) const {
  if (!has_linear_projection())
    throw std::invalid_argument("the efforts of this torque distribution are not a linear function of the forces");
  Matrix selection = actuation_selection(equations);
  ActuationFactors factors(values_of(closure_jacobian(equations)), values_of(selection), freedoms_);
  if (!factors.is_regular) return false;
  if (distribution_) {
    scale_selection(selection);
    factors.selection.compute(factors.null_space.transpose() * values_of(selection).transpose(),
                              Eigen::ComputeThinU | Eigen::ComputeThinV);
  }
  const Eigen::Map<const VectorX> columns(equations.column_scale().data(), columns_);
  if (freedoms_ > 0) projection = factors.selection.solve(factors.null_space.transpose() * columns.asDiagonal());
  for (std::size_t a = 0; a < actuated_.size(); ++a)
    projection.row(static_cast<Eigen::Index>(a)) /=
        distribution_ ? value_of(distribution_->unit[a]) : actuated_[a].unit;
  return true;
}

template class Actuation<PlanarOf<EngineScalar>>;
template class Actuation<SpatialOf<EngineScalar>>;

// How well the actuators hold a mechanism: closures and actuated coordinates as one matrix.
template <class S>
auto Actuation<S>::closure_jacobian(const KinematicEquations<S>& equations) const -> Matrix {
  Matrix closures(closures_, columns_);
  for (int r = 0; r < closures_; ++r)
    for (int c = 0; c < columns_; ++c) closures(r, c) = equations.entry(r, c);
  return closures;
}

/// Maps scaled tree coordinates to scaled actuated ones. The minimum norm of efforts is then the same in all units,
/// with forces counted as moments at the characteristic length.
template <class S>
auto Actuation<S>::actuation_selection(const KinematicEquations<S>& equations) const -> Matrix {
  Matrix selection = Matrix::Zero(static_cast<Eigen::Index>(actuated_.size()), columns_);
  const std::vector<double>& scale = equations.column_scale();
  for (std::size_t a = 0; a < actuated_.size(); ++a) {
    const ActuatedCoordinate& motor = actuated_[a];
    const auto row = static_cast<Eigen::Index>(a);
    selection(row, motor.column) = motor.ratio * scale[motor.column] / motor.unit;
    for (const auto& [column, ratio] : motor.further_terms) selection(row, column) = ratio * scale[column] / motor.unit;
  }
  return selection;
}

template <class S>
VectorX Actuation<S>::singular_values_without(std::size_t actuator, const KinematicEquations<S>& equations) const {
  MatrixX matrix = actuation_matrix(equations);
  matrix.row(closures_ + static_cast<Eigen::Index>(actuator)).setZero();
  return numerics::singular_values(matrix);
}

template <class S>
MatrixX Actuation<S>::actuation_matrix(const KinematicEquations<S>& equations) const {
  MatrixX matrix(closures_ + static_cast<Eigen::Index>(actuated_.size()), columns_);
  matrix << values_of(closure_jacobian(equations)), values_of(actuation_selection(equations));
  return matrix;
}

/// Prepares the sparsity pattern of actuation_matrix() for a large mechanism.
template <class S>
void Actuation<S>::prepare_actuation_matrix() {
  numerics::SparsityPattern pattern(static_cast<std::size_t>(columns_));
  for (const ClosureEntry& entry : closure_entries_) pattern[entry.row].push_back(entry.column);
  for (const std::vector<ClosureEntry>& column : motor_column_entries_)
    for (const ClosureEntry& entry : column) pattern[entry.row].push_back(entry.column);
  for (std::size_t a = 0; a < actuated_.size(); ++a) pattern[closures_ + a].push_back(actuated_[a].column);
  for (std::vector<int>& row : pattern) std::sort(row.begin(), row.end());
  has_sparse_matrix_ = sparse_matrix_.analyse(pattern);
}

template <class S>
std::optional<double> Actuation<S>::sparse_mobility(const KinematicEquations<S>& equations) const {
  numerics::BlockTriangular factors = sparse_matrix_;
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
  return numerics::smallest_singular_value(actuation_matrix(equations));
}

using OnPlane = Actuation<PlanarOf<EngineScalar>>;
using InSpace = Actuation<SpatialOf<EngineScalar>>;
template OnPlane::Matrix OnPlane::closure_jacobian(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template InSpace::Matrix InSpace::closure_jacobian(const KinematicEquations<SpatialOf<EngineScalar>>&) const;
template OnPlane::Matrix OnPlane::actuation_selection(const KinematicEquations<PlanarOf<EngineScalar>>&) const;
template InSpace::Matrix InSpace::actuation_selection(const KinematicEquations<SpatialOf<EngineScalar>>&) const;
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

}  // namespace balance::dynamics
