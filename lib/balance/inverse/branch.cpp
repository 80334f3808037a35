#include "balance/inverse/branch.hpp"

#include "balance/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace balance {

namespace {

constexpr double newton_residual_tolerance = 1e-12;  // scaled residual after which one correction is the last
constexpr double max_correction = 0.1;               // of a prediction, in radians or characteristic lengths
constexpr int max_newton_iterations = 8;

template <class S>
Drive<S> make_independent_drive(const Mechanism& mechanism, const Tree<S>& tree,
                                const std::vector<CoordinateId>& coordinates) {
  Drive<S> drive;
  for (const int c : coordinates) drive.linear.push_back(find_coordinate_expression(mechanism, tree, c));
  return drive;
}

template <class S>
bool has_single_terms(const Tree<S>& tree, const std::vector<CoordinateId>& coordinates) {
  return std::all_of(coordinates.begin(), coordinates.end(),
                     [&](int c) { return tree.coordinate_expressions[static_cast<std::size_t>(c)].has_single_term(); });
}

}  // namespace

template <class S>
AssemblyBranch<S>::AssemblyBranch(const Mechanism& mechanism, IndependentCoordinates<S> choice)
    : mechanism_(mechanism),
      tree_(std::move(choice.tree)),
      needed_(std::move(choice.needed)),
      independent_(std::move(choice.coordinates)),
      note_(std::move(choice.note)),
      freedoms_(choice.freedoms),
      redundant_(choice.redundant),
      direct_(tree_.closures.empty() && has_single_terms(tree_, independent_)),
      drive_(make_independent_drive(mechanism, tree_, independent_)),
      equations_(tree_, drive_, redundant_),
      round_off_(newton_residual_tolerance * ground_extent(mechanism)),
      state_(tree_.nodes.size()) {
  for (const LinearQuantity& quantity : drive_.linear)
    columns_.push_back({quantity.terms[0].first, 1 / quantity.terms[0].second, quantity.constant});
  plain_ = direct_;
  for (std::size_t k = 0; k < columns_.size(); ++k)
    plain_ = plain_ && columns_[k].column == static_cast<int>(k) && columns_[k].inverse == 1 && columns_[k].offset == 0;
  std::set<ColumnId> matrix_columns;
  for (const Closure<S>& closure : tree_.closures)
    for (const PathStep& part : closure.path) matrix_columns.insert(tree_.nodes[part.node].column);
  matrix_columns_.assign(matrix_columns.begin(), matrix_columns.end());
  for (const NodeId spherical : tree_.spherical_joints) initial_references_.push_back(tree_.nodes[spherical].R_PF);
  for (VectorX* values : {&y_, &dy_, &ddy_, &predicted_, &trial_}) values->setZero(tree_.columns);
  for (VectorX* values : {&sample_.value, &sample_.rate, &sample_.acceleration}) values->setZero(freedoms_);
  q_.assign(static_cast<std::size_t>(freedoms_), 0);
  x_.assign(static_cast<std::size_t>(std::max(tree_.columns, equations_.rows())), 0);
}

template <class S>
bool AssemblyBranch<S>::newton(VectorX& y, const double* q) {
  has_current_equations_ = false;
  std::copy_n(q, freedoms_, sample_.value.data());
  double last = INFINITY;
  for (iterations_ = 0; iterations_ <= max_newton_iterations; ++iterations_) {
    compute_poses(tree_, y.data(), state_);
    equations_.evaluate(state_, y.data(), sample_, x_.data());
    double worst = 0;
    for (int r = 0; r < equations_.rows(); ++r) worst = std::max(worst, std::abs(x_[r]));
    if (!std::isfinite(worst) || !equations_.factorise()) return false;
    equations_.solve(x_.data());
    for (int c = 0; c < tree_.columns; ++c) y[c] -= x_[c];
    if (worst <= round_off_ || (worst <= 10 * round_off_ && worst >= last)) return true;
    last = worst;
  }
  return false;
}

/// Equations and poses at q_ and y_, whose coordinates may be counted from new references.
template <class S>
bool AssemblyBranch<S>::update_equations() {
  reset_spherical_references();
  if (!newton(y_, q_.data())) return false;
  equations_.store();
  has_current_equations_ = true;
  return true;
}

template <class S>
bool AssemblyBranch<S>::reset_spherical_references() {
  constexpr double max_middle_angle = 1;  // at a right angle a spherical joint's coordinates fail
  bool any = false;
  for (const NodeId spherical : tree_.spherical_joints) {
    const double middle = std::remainder(y_[tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < max_middle_angle) continue;
    reset_spherical_reference(tree_, spherical, y_.data());
    any = true;
  }
  return any;
}

/// To a state so near that neither the mode nor the sign of a determinant can have changed on the way.
template <class S>
bool AssemblyBranch<S>::step(const double* q) {
  if (!has_current_equations_ && !update_equations()) return false;
  std::fill(x_.begin(), x_.end(), 0);
  for (int k = 0; k < freedoms_; ++k) {
    const int row = tree_.closure_rows + k;
    x_[row] = equations_.row_scale()[row] * (q[k] - q_[k]);
  }
  equations_.solve(x_.data());
  const std::vector<double>& scale = equations_.column_scale();
  for (int c = 0; c < tree_.columns; ++c) predicted_[c] = y_[c] + x_[c];
  trial_ = predicted_;
  if (!newton(trial_, q)) return false;
  for (int c = 0; c < tree_.columns; ++c)
    if (!(std::abs(trial_[c] - predicted_[c]) <= max_correction * scale[c])) return false;
  double way = 0;
  for (const int c : matrix_columns_) way = std::max(way, std::abs(trial_[c] - y_[c]) / scale[c]);
  if (!(way * way <= max_matrix_curvature * equations_.regularity()) || !equations_.is_near_stored(max_matrix_change))
    return false;
  std::swap(y_, trial_);
  std::copy_n(q, freedoms_, q_.begin());
  has_current_equations_ = true;
  if (reset_spherical_references()) return update_equations();
  equations_.store();
  return true;
}

template <class S>
void AssemblyBranch<S>::set_rates(const double* dq) {
  if (direct_) return set_direct(dq, 0, dy_.data());
  std::copy_n(dq, freedoms_, sample_.rate.data());
  equations_.velocity_rhs(sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, dy_.data());
  compute_angular_velocities(tree_, dy_.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, dy_.data(), state_);
}

template <class S>
void AssemblyBranch<S>::set_accelerations(const double* ddq) {
  if (direct_) return set_direct(ddq, 0, ddy_.data());
  std::copy_n(ddq, freedoms_, sample_.acceleration.data());
  compute_accelerations<S>(tree_, dy_.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, ddy_.data());
}

template <class S>
void AssemblyBranch<S>::fill_transformation(MatrixX& C) {
  C.setZero(tree_.columns, freedoms_);
  for (int k = 0; k < freedoms_; ++k) {
    if (direct_) {
      C(columns_[static_cast<std::size_t>(k)].column, k) = columns_[static_cast<std::size_t>(k)].inverse;
      continue;
    }
    std::fill(x_.begin(), x_.end(), 0);
    const int row = tree_.closure_rows + k;
    x_[row] = equations_.row_scale()[row];
    equations_.solve(x_.data());
    C.col(k) = Eigen::Map<const VectorX>(x_.data(), tree_.columns);
  }
}

template <class S>
VectorX AssemblyBranch<S>::coordinates() const {
  const std::vector<double> wrapped = compute_coordinates(mechanism_, tree_, y_);
  VectorX all = Eigen::Map<const VectorX>(wrapped.data(), static_cast<Eigen::Index>(wrapped.size()));
  for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
    const LinearQuantity& source = tree_.coordinate_expressions[c];
    if (source.has_terms() && !tree_.is_floating[c]) all[static_cast<Eigen::Index>(c)] = source.value(y_.data());
  }
  return all;
}

template class AssemblyBranch<Planar>;
template class AssemblyBranch<Spatial>;

}  // namespace balance
