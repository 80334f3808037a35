#include "balance/synthesis/conditions/configuration_sampler.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include <cmath>
#include <numbers>

namespace balance {

namespace {

constexpr double max_step = 0.2;             ///< in scaled coordinates
constexpr double min_sample_distance = 0.5;  ///< way between configurations that are used
constexpr double step_per_singular_value =
    0.5;  ///< step per smallest singular value: no step can leap over a singular configuration
constexpr double min_singular_value_ratio =
    0.1;  ///< to a singular configuration: smallest singular value against the largest such seen
constexpr double ill_conditioned_step = 0.02;  ///< as long as steps get where loops are ill-conditioned everywhere
constexpr double step_growth_threshold =
    0.1;  ///< change of the smallest singular value after which the next step may be twice as long
constexpr double max_slide_range = 4;  ///< slides stay within so many characteristic lengths
constexpr double max_spherical_angle =
    1.25;  ///< of a spherical joint's second angle [rad]: its coordinates degenerate at π/2

}  // namespace

double UniformRandom::uniform(double lower, double upper) {
  // written out: the standard's distributions differ between libraries
  return lower + (upper - lower) * static_cast<double>(bits_() >> 11) * 0x1.0p-53;
}

VectorX UniformRandom::normal(Eigen::Index size) {
  VectorX values(size);
  for (double& value : values)
    value = std::sqrt(-2 * elementary::log(1 - uniform(0, 1))) * elementary::cos(2 * std::numbers::pi * uniform(0, 1));
  return values;
}

template <class S>
ConfigurationSampler<S>::ConfigurationSampler(const Mechanism& mechanism, Tree<S>& tree, std::uint64_t seed)
    : mechanism_(mechanism), tree_(tree), closures_(tree, Drive<S>{}), scale_(column_scale(tree)), random_(seed) {}

template <class S>
bool ConfigurationSampler<S>::next(SampledConfiguration& configuration) {
  if (tree_.position_rows == 0) {
    configuration.y.resize(tree_.columns);
    for (int c = 0; c < tree_.columns; ++c)
      configuration.y[c] = tree_.is_length_column[static_cast<std::size_t>(c)] == 0
                               ? random_.uniform(-std::numbers::pi, std::numbers::pi)
                               : scale_[c] * random_.uniform(-1, 1);
    freedoms_ = tree_.columns - (tree_.closure_rows == 0 ? 0 : find_generic_closure_rank(tree_, configuration.y));
    return freedoms_ > 0 && project_onto_closures(closures_, configuration.y, freedoms_, configuration);
  }
  if (!started_ && !find_start()) return false;
  double way = 0;
  for (int tries = 0; tries < 2000; ++tries) {
    way += take_step();
    if (way < min_sample_distance) continue;
    configuration = {y_, null_space_};
    return true;
  }
  return false;
}

/// Into the mode that the assembly values pick, and away from a singular configuration if that is where it is.
template <class S>
bool ConfigurationSampler<S>::find_start() {
  const AssemblySolution found = solve_pose(mechanism_, tree_, closures_, {});
  if (!found.found) return false;
  y_ = found.y;
  for (const NodeId spherical : tree_.spherical_joints) reset_spherical_reference(tree_, spherical, y_.data());
  rank_ = find_generic_closure_rank(tree_, y_);
  freedoms_ = tree_.columns - rank_;
  if (freedoms_ == 0) return false;
  evaluate_regularity(y_);
  y_ = current_.y;
  null_space_ = current_.null_space;
  max_singular_value_ = accepted_singular_value_ = min_singular_value_;
  direction_ = null_space_ * random_.normal(null_space_.cols());
  direction_.normalize();
  started_ = true;
  return true;
}

/// The velocities allowed at y, and how far from losing rank the loops are there.
template <class S>
void ConfigurationSampler<S>::evaluate_regularity(const VectorX& y) {
  MatrixX jacobian;
  closures_.velocity_jacobian(y, {}, jacobian);
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  min_singular_value_ = rank_ > 0 ? svd.singularValues()[rank_ - 1] : max_step / step_per_singular_value;
  current_ = {y, svd.matrixV().rightCols(freedoms_)};
}

/// Straight on, a little aside where there is a choice, and never through a singular configuration, beyond which another branch
/// may begin. @return the way gone in scaled coordinates, 0 if there is none in this direction
template <class S>
double ConfigurationSampler<S>::take_step() {
  const double careful = std::min(max_step, step_per_singular_value * accepted_singular_value_);
  const double stride = std::max(careful, std::min(ill_conditioned_step, careful * step_factor_));
  const AssemblySolution moved = solve_assembly(closures_, y_ + stride * scale_.cwiseProduct(direction_), {}, 30);
  const VectorX went = (moved.y - y_).cwiseQuotient(scale_);
  bool good = moved.found && went.dot(direction_) > 0.7 * went.norm() && went.norm() > 0.3 * stride &&
              went.norm() < 2 * stride && !is_out_of_range(moved.y);
  if (good) {
    evaluate_regularity(moved.y);
    good = min_singular_value_ > min_singular_value_ratio * max_singular_value_ ||
           min_singular_value_ > accepted_singular_value_;
  }
  step_factor_ = good && std::abs(min_singular_value_ - accepted_singular_value_) <
                             step_growth_threshold * accepted_singular_value_
                     ? 2 * step_factor_
                     : 1;
  if (!good) {
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
  return went.norm();
}

/// Changes the direction at random: amount 1 forgets the old one, and with one freedom goes back.
template <class S>
void ConfigurationSampler<S>::perturb_direction(double amount) {
  if (freedoms_ == 1) {
    direction_ = -direction_;
    return;
  }
  VectorX other = null_space_ * random_.normal(freedoms_);
  other.normalize();
  direction_ = (1 - amount) * direction_ + amount * other;
  direction_.normalize();
}

template <class S>
bool ConfigurationSampler<S>::is_out_of_range(const VectorX& y) const {
  for (int c = 0; c < tree_.columns; ++c)
    if (tree_.is_length_column[static_cast<std::size_t>(c)] != 0 && std::abs(y[c]) > max_slide_range * scale_[c])
      return true;
  for (const NodeId spherical : tree_.spherical_joints) {
    const Node<S>& middle = tree_.nodes[static_cast<std::size_t>(spherical) + 1];
    if (middle.motion != NodeMotion::weld &&
        std::abs(middle.ratio * y[middle.column] + middle.offset) > max_spherical_angle)
      return true;
  }
  return false;
}

template <class S>
bool project_onto_closures(ConstraintSystem<S>& closures, const VectorX& y, int freedoms, SampledConfiguration& here) {
  here.y = y;
  if (closures.closure_rows() == 0) {
    here.null_space = MatrixX::Identity(closures.columns(), closures.columns());
    return true;
  }
  if (closures.place_rows() > 0) {
    const AssemblySolution moved = solve_assembly(closures, y, {}, 40);
    if (!moved.found) return false;
    here.y = moved.y;
  }
  MatrixX jacobian;
  closures.velocity_jacobian(here.y, {}, jacobian);
  // beyond the rank the orthogonal factor spans what no row sees
  const ColumnPivotingQr qr(jacobian.transpose());
  const MatrixX q = qr.householderQ() * MatrixX::Identity(jacobian.cols(), jacobian.cols());
  here.null_space = q.rightCols(freedoms);
  return true;
}

template bool project_onto_closures(ConstraintSystem<Planar>&, const VectorX&, int, SampledConfiguration&);
template bool project_onto_closures(ConstraintSystem<Spatial>&, const VectorX&, int, SampledConfiguration&);

template <class S>
std::string ConfigurationSampler<S>::infeasibility_reason() {
  const AssemblySolution start = solve_pose(mechanism_, tree_, closures_, {});
  if (!start.found) return explain_assembly_failure(mechanism_, tree_, start, {}).reason;
  return started_ ? "too few configurations are connected to the one it is assembled in" : "the mechanism cannot move";
}

template class ConfigurationSampler<Planar>;
template class ConfigurationSampler<Spatial>;

}  // namespace balance
