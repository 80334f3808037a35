#include "balance/synthesis/conditions/configuration_sampler.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include <cmath>
#include <numbers>

namespace balance::conditions {

namespace {

constexpr double max_step = 0.2;             ///< in scaled coordinates
constexpr double min_sample_distance = 0.5;  ///< path length between sampled configurations
constexpr double step_per_singular_value =
    0.5;  ///< maximum step per smallest singular value, so that no step jumps across a singular configuration
constexpr double min_singular_value_ratio =
    0.1;  ///< minimum of the smallest singular value relative to its maximum so far
constexpr double ill_conditioned_step = 0.02;  ///< maximum step where the loops are ill-conditioned everywhere
constexpr double step_growth_threshold =
    0.1;  ///< relative change of the smallest singular value below which the next step may be twice as long
constexpr double max_slide_range = 4;  ///< limit of slides in characteristic lengths
constexpr double max_spherical_angle =
    1.25;  ///< limit of a spherical joint's second angle [rad]: its coordinates are singular at π/2

}  // namespace

template <class S>
ConfigurationSampler<S>::ConfigurationSampler(const Mechanism& mechanism, kinematics::Tree<S>& tree, std::uint64_t seed)
    : mechanism_(mechanism),
      tree_(tree),
      closures_(tree, kinematics::Drive<S>{}),
      scale_(column_scale(tree)),
      random_(seed) {}

template <class S>
bool ConfigurationSampler<S>::next(SampledConfiguration& configuration) {
  if (tree_.position_rows == 0) {
    configuration.y.resize(tree_.columns);
    for (int c = 0; c < tree_.columns; ++c)
      configuration.y[c] = tree_.is_length_column[static_cast<std::size_t>(c)] == 0
                               ? random_(-std::numbers::pi, std::numbers::pi)
                               : scale_[c] * random_(-1, 1);
    freedoms_ = tree_.columns - (tree_.closure_rows == 0 ? 0 : find_generic_closure_rank(tree_, configuration.y));
    return freedoms_ > 0 && project_onto_closures(closures_, configuration.y, freedoms_, configuration);
  }
  if (!started_ && !find_start()) return false;
  double path_length = 0;
  for (int attempts = 0; attempts < 2000; ++attempts) {
    path_length += take_step();
    if (path_length < min_sample_distance) continue;
    configuration = {y_, null_space_};
    return true;
  }
  return false;
}

/// Starts in the assembly mode that the assembly values select.
template <class S>
bool ConfigurationSampler<S>::find_start() {
  const kinematics::AssemblySolution assembly = kinematics::solve_pose(mechanism_, tree_, closures_, {});
  if (!assembly.found) return false;
  y_ = assembly.y;
  for (const kinematics::NodeId spherical : tree_.spherical_joints)
    reset_spherical_reference(tree_, spherical, y_.data());
  rank_ = find_generic_closure_rank(tree_, y_);
  freedoms_ = tree_.columns - rank_;
  if (freedoms_ == 0) return false;
  evaluate_regularity(y_);
  y_ = current_.y;
  null_space_ = current_.null_space;
  max_singular_value_ = accepted_singular_value_ = min_singular_value_;
  direction_ = null_space_ * random_.sample_normal(null_space_.cols());
  direction_.normalize();
  started_ = true;
  return true;
}

/// Finds the admissible velocities at y and the distance of the closures from losing rank there.
template <class S>
void ConfigurationSampler<S>::evaluate_regularity(const VectorX& y) {
  MatrixX jacobian;
  closures_.velocity_jacobian(y, {}, jacobian);
  const numerics::SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  min_singular_value_ = rank_ > 0 ? svd.singularValues()[rank_ - 1] : max_step / step_per_singular_value;
  current_ = {y, svd.matrixV().rightCols(freedoms_)};
}

/// Steps straight ahead, slightly aside where there is a choice, and never through a singular configuration, beyond
/// which another branch may begin.
/// @return the path length in scaled coordinates; 0 if this direction is blocked
template <class S>
double ConfigurationSampler<S>::take_step() {
  const double regular_step = std::min(max_step, step_per_singular_value * accepted_singular_value_);
  const double step_length = std::max(regular_step, std::min(ill_conditioned_step, regular_step * step_factor_));
  const kinematics::AssemblySolution assembly =
      kinematics::solve_assembly(closures_, y_ + step_length * scale_.cwiseProduct(direction_), {}, 30);
  const VectorX displacement = (assembly.y - y_).cwiseQuotient(scale_);
  bool is_accepted = assembly.found && displacement.dot(direction_) > 0.7 * displacement.norm() &&
                     displacement.norm() > 0.3 * step_length && displacement.norm() < 2 * step_length &&
                     !is_out_of_range(assembly.y);
  if (is_accepted) {
    evaluate_regularity(assembly.y);
    is_accepted = min_singular_value_ > min_singular_value_ratio * max_singular_value_ ||
                  min_singular_value_ > accepted_singular_value_;
  }
  step_factor_ = is_accepted && std::abs(min_singular_value_ - accepted_singular_value_) <
                                    step_growth_threshold * accepted_singular_value_
                     ? 2 * step_factor_
                     : 1;
  if (!is_accepted) {
    perturb_direction(1);
    return 0;
  }
  y_ = current_.y;
  null_space_ = current_.null_space;
  accepted_singular_value_ = min_singular_value_;
  max_singular_value_ = std::max(max_singular_value_, accepted_singular_value_);
  direction_ = null_space_ * (null_space_.transpose() * direction_);
  direction_.normalize();
  if (freedoms_ > 1) perturb_direction(0.3);
  return displacement.norm();
}

/// Changes the direction at random; amount 1 discards the old one. With one freedom, reverses it.
template <class S>
void ConfigurationSampler<S>::perturb_direction(double amount) {
  if (freedoms_ == 1) {
    direction_ = -direction_;
    return;
  }
  VectorX other = null_space_ * random_.sample_normal(freedoms_);
  other.normalize();
  direction_ = (1 - amount) * direction_ + amount * other;
  direction_.normalize();
}

template <class S>
bool ConfigurationSampler<S>::is_out_of_range(const VectorX& y) const {
  for (int c = 0; c < tree_.columns; ++c)
    if (tree_.is_length_column[static_cast<std::size_t>(c)] != 0 && std::abs(y[c]) > max_slide_range * scale_[c])
      return true;
  for (const kinematics::NodeId spherical : tree_.spherical_joints) {
    const kinematics::Node<S>& middle = tree_.nodes[static_cast<std::size_t>(spherical) + 1];
    if (middle.motion != kinematics::NodeMotion::weld &&
        std::abs(middle.ratio * y[middle.column] + middle.offset) > max_spherical_angle)
      return true;
  }
  return false;
}

template <class S>
bool project_onto_closures(kinematics::ConstraintSystem<S>& closures, const VectorX& y, int freedoms,
                           SampledConfiguration& sample) {
  sample.y = y;
  if (closures.closure_rows() == 0) {
    sample.null_space = MatrixX::Identity(closures.columns(), closures.columns());
    return true;
  }
  if (closures.place_rows() > 0) {
    const kinematics::AssemblySolution assembly = kinematics::solve_assembly(closures, y, {}, 40);
    if (!assembly.found) return false;
    sample.y = assembly.y;
  }
  MatrixX jacobian;
  closures.velocity_jacobian(sample.y, {}, jacobian);
  // beyond the rank, the columns of Q span the null space
  const numerics::ColumnPivotingQr qr(jacobian.transpose());
  const MatrixX q = qr.householderQ() * MatrixX::Identity(jacobian.cols(), jacobian.cols());
  sample.null_space = q.rightCols(freedoms);
  return true;
}

template bool project_onto_closures(kinematics::ConstraintSystem<kinematics::Planar>&, const VectorX&, int,
                                    SampledConfiguration&);
template bool project_onto_closures(kinematics::ConstraintSystem<kinematics::Spatial>&, const VectorX&, int,
                                    SampledConfiguration&);

template <class S>
std::string ConfigurationSampler<S>::infeasibility_reason() {
  const kinematics::AssemblySolution start = kinematics::solve_pose(mechanism_, tree_, closures_, {});
  if (!start.found) return kinematics::explain_assembly_failure(mechanism_, tree_, start, {}).reason;
  return started_ ? "too few configurations can be reached from the assembled one" : "the mechanism cannot move";
}

template class ConfigurationSampler<kinematics::Planar>;
template class ConfigurationSampler<kinematics::Spatial>;

}  // namespace balance::conditions
