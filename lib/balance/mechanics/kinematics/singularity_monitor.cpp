#include "balance/mechanics/kinematics/singularity_monitor.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>

namespace balance::kinematics {

namespace {

constexpr std::size_t max_loops = 64;

template <class S>
using LoopTwist = Eigen::Matrix<double, S::dimension + S::angular_dimension, 1>;

void put_angular(LoopTwist<Planar>& twist, double value) { twist[2] = value; }
void put_angular(LoopTwist<Spatial>& twist, const Vector3& value) { twist.tail<3>() = value; }

/// Twist per unit rate of a node's coordinate (per characteristic length, if that is a length): velocity at a point in
/// characteristic lengths, angular velocity.
template <class S>
LoopTwist<S> twist_of(const Tree<S>& tree, int n, const TreeState<S>& poses, const typename S::Vector& about) {
  const Node<S>& node = tree.nodes[n];
  const double scale = tree.is_length_column[node.column] != 0 ? tree.characteristic_length : 1;
  LoopTwist<S> twist = LoopTwist<S>::Zero();
  twist.template head<S::dimension>() = scale / tree.characteristic_length * partial_velocity(node, poses[n], about);
  if (node.motion == NodeMotion::revolute)
    put_angular(twist, typename S::Angular(scale * node.ratio * revolute_axis(poses[n].R_WN)));
  return twist;
}

/// Twists of b relative to a that a closure leaves free: those on which its wrenches do no work.
template <class S>
MatrixX find_free_twists(const Tree<S>& tree, const Closure<S>& closure, const TreeState<S>& poses,
                         const typename S::Vector& about) {
  const ClosurePose<S> pose = closure_pose(poses, closure);
  const auto rows = static_cast<Eigen::Index>(closure.rows.size());
  MatrixX wrenches(rows, S::dimension + S::angular_dimension);
  const typename S::Vector arm = (pose.p_B - about) / tree.characteristic_length;
  for (Eigen::Index r = 0; r < rows; ++r) {
    const ConstraintWrench<S> wrench = closure_wrench(closure, pose, closure.rows[static_cast<std::size_t>(r)]);
    LoopTwist<S> row = LoopTwist<S>::Zero();
    row.template head<S::dimension>() = wrench.force;
    put_angular(row, typename S::Angular(wrench.moment + cross(arm, wrench.force)));
    wrenches.row(r) = row;
  }
  const numerics::SingularValueDecomposition svd(wrenches, Eigen::ComputeFullV);
  return svd.matrixV().rightCols(wrenches.cols() - rows);
}

}  // namespace

template <class S>
LoopRankMonitor<S>::LoopRankMonitor(const Mechanism& mechanism, const Tree<S>& tree)
    : mechanism_(mechanism), tree_(tree), loops_(list_simple_loops(mechanism, max_loops)) {}

template <class S>
std::string LoopRankMonitor<S>::joint_names(std::size_t loop) const {
  std::string names;
  for (const model::LoopStep& step : loops_[loop])
    names += (names.empty() ? "" : ", ") + mechanism_.joints[static_cast<std::size_t>(step.joint)].name;
  return names;
}

/// Adds a tree joint's twists to the columns of its coordinates, or appends columns for a cut joint.
template <class S>
void LoopRankMonitor<S>::add_joint_twists(const model::LoopStep& step, const TreeState<S>& poses,
                                          const typename S::Vector& about, MatrixX& twists) const {
  const auto joint = static_cast<std::size_t>(step.joint);
  const int last = tree_.joint_nodes[joint];
  if (last < 0) {
    for (const Closure<S>& closure : tree_.closures) {
      if (closure.joint != step.joint || closure.split || closure.is_velocity_level()) continue;
      const MatrixX free_twists = find_free_twists(tree_, closure, poses, about);
      twists.conservativeResize(Eigen::NoChange, twists.cols() + free_twists.cols());
      twists.rightCols(free_twists.cols()) = free_twists;
    }
    return;
  }
  const bool tree_forward = tree_.joint_forward[joint];
  const double sign = step.forward == tree_forward ? 1 : -1;
  const Joint& traversed = mechanism_.joints[joint];
  const int first = tree_.bodies[static_cast<std::size_t>(tree_forward ? traversed.first : traversed.second)].node;
  for (int n = last; n != first && n > 0; n = tree_.nodes[n].parent)
    if (tree_.nodes[n].motion != NodeMotion::weld)
      twists.col(tree_.nodes[n].column) += sign * twist_of(tree_, n, poses, about);
}

template <class S>
VectorX LoopRankMonitor<S>::singular_values(std::size_t loop, const TreeState<S>& poses) const {
  const Joint& start = mechanism_.joints[static_cast<std::size_t>(loops_[loop].front().joint)];
  const FixedFrame<S>& frame = tree_.bodies[static_cast<std::size_t>(start.first)];
  const typename S::Vector about =
      poses[frame.node].p_WN +
      poses[frame.node].R_WN * typename S::Vector(frame.p_N + frame.R_N * to_vector<S>(start.point_first));
  MatrixX twists = MatrixX::Zero(S::dimension + S::angular_dimension, tree_.columns);
  for (const model::LoopStep& step : loops_[loop]) add_joint_twists(step, poses, about, twists);
  return numerics::singular_values(twists);
}

template class LoopRankMonitor<Planar>;
template class LoopRankMonitor<Spatial>;

namespace {

/// Pivots below this are tracked: both ends of a step may be about three times as far from a singularity as the nearest
/// point in between.
constexpr double monitor_threshold = 4 * numerics::near_singular_pivot_threshold;

/// Distance between examinations of the redundant matrices [rad]; two of their singular configurations are never closer
/// than twice this.
constexpr double sample_angle = 0.05;

/// Singular values that count as zero, for matrix entries of order one.
constexpr double zero_singular_value_tolerance = 1e-6;

}  // namespace

template <class S>
SingularityMonitor<S>::SingularityMonitor(const Mechanism& mechanism, const Tree<S>& tree,
                                          const CompiledTrajectory<S>& plan, const History& steps)
    : mechanism_(mechanism), interpolator_(tree, plan), steps_(steps) {
  if (!plan.has_redundant_closures) return;  // independent closures stay independent, and so do those of each loop
  loops_.emplace(mechanism, tree);
  for (std::size_t k = 0; k < loops_->loop_count(); ++k) redundant_matrices_.push_back({.index = k});
}

template <class S>
void SingularityMonitor<S>::monitor_actuation(const RegularityMonitor<S>& monitor) {
  regularity_monitor_ = &monitor;
  std::erase_if(redundant_matrices_, [](const RedundantMatrix& matrix) { return matrix.is_actuation; });
  for (std::size_t k = 0; k < monitor.redundant_count(); ++k)
    redundant_matrices_.push_back({.index = k, .is_actuation = true});
}

template <class S>
void SingularityMonitor<S>::push_coarse_sample() {
  std::swap(coarse_samples_[0], coarse_samples_[1]);
  std::swap(coarse_samples_[1], coarse_samples_[2]);
  coarse_samples_[2] = *steps_[2];
}

template <class S>
bool SingularityMonitor<S>::interpolate(const History& history, double time) {
  if (time == interpolated_time_) return true;
  const auto& [a, b, c] = history;
  const bool is_interpolated =
      time < b->time ? interpolator_.interpolate(*a, *b, time) : interpolator_.interpolate(*b, *c, time);
  interpolated_time_ = is_interpolated ? time : NAN;
  return is_interpolated;
}

template <class S>
void SingularityMonitor<S>::begin(const KinematicEquations<S>& equations, double pivot, double actuation_pivot) {
  motion_ = actuation_ = {};
  for (RedundantMatrix& matrix : redundant_matrices_) matrix.rank = 0, matrix.rank_loss_times.clear();
  start_ = steps_[2]->time;
  restart(equations, pivot, actuation_pivot);
}

template <class S>
void SingularityMonitor<S>::restart(const KinematicEquations<S>& equations, double pivot, double actuation_pivot) {
  motion_.minimum_tracker.reset();
  actuation_.minimum_tracker.reset();
  interpolated_time_ = NAN;
  sample_distances(equations, pivot, actuation_pivot);
  if (redundant_matrices_.empty()) return;
  for (RedundantMatrix& matrix : redundant_matrices_) matrix.minimum_tracker.reset();
  coarse_samples_[2] = *steps_[2];
  sample_redundant_matrices();
}

template <class S>
void SingularityMonitor<S>::sample(const KinematicEquations<S>& equations, double pivot, double actuation_pivot,
                                   double distance) {
  sample_distances(equations, pivot, actuation_pivot);
  if (redundant_matrices_.empty()) return;
  rotation_since_sample_ += distance;
  has_pending_step_ = rotation_since_sample_ < sample_angle;
  if (!has_pending_step_) sample_redundant_matrices();
}

template <class S>
void SingularityMonitor<S>::sample_distances(const KinematicEquations<S>& equations, double pivot,
                                             double actuation_pivot) {
  sample_distance(motion_, equations, pivot,
                  [](const KinematicEquations<S>& evaluated) { return evaluated.distance_to_singularity(); });
  if (regularity_monitor_ != nullptr)
    sample_distance(actuation_, equations, actuation_pivot, [this](const KinematicEquations<S>& evaluated) {
      return regularity_monitor_->mobility(evaluated);
    });
}

template <class S>
template <class Mobility>
void SingularityMonitor<S>::sample_distance(NearSingularity& approach, const KinematicEquations<S>& equations,
                                            double pivot, const Mobility& mobility) {
  numerics::LocalMinimumTracker::TimedValue current{steps_[2]->time, INFINITY};
  if (pivot < monitor_threshold) {
    current.value = mobility(equations);
    if (current.value < approach.mobility) approach.pivot_per_mobility = pivot / current.value;
    approach.update_minimum(current);
  }
  const auto value_at = [&](double time) {
    return interpolate(steps_, time) ? mobility(interpolator_.equations()) : INFINITY;
  };
  approach.minimum_tracker.add_sample(current, value_at, [&](const numerics::LocalMinimumTracker::TimedValue& minimum) {
    approach.update_minimum(minimum);
  });
}

template <class S>
void SingularityMonitor<S>::sample_redundant_matrices() {
  const double end_time = steps_[2]->time, start_time = coarse_history_[2]->time, interval = end_time - start_time;
  const int interval_count = std::max(1, static_cast<int>(std::ceil(rotation_since_sample_ / sample_angle)));
  push_coarse_sample();
  rotation_since_sample_ = 0;
  has_pending_step_ = false;
  for (int k = 1; k <= interval_count; ++k) {
    const double time = k == interval_count ? end_time : start_time + interval * k / interval_count;
    for (RedundantMatrix& matrix : redundant_matrices_)
      if (interpolate(coarse_history_, time)) sample_redundant_matrix(matrix, time);
  }
}

template <class S>
VectorX SingularityMonitor<S>::singular_values(const RedundantMatrix& matrix) const {
  return matrix.is_actuation ? regularity_monitor_->singular_values_without(matrix.index, interpolator_.equations())
                             : loops_->singular_values(matrix.index, interpolator_.state());
}

/// The singular value that vanishes if the matrix loses rank. Infinite for an omitted actuator if the remaining ones do
/// not determine everything to begin with.
template <class S>
double SingularityMonitor<S>::decisive_singular_value(const RedundantMatrix& matrix, const VectorX& sigma) const {
  if (matrix.rank == 0 || (matrix.is_actuation && matrix.rank < interpolator_.equations().columns())) return INFINITY;
  return sigma[matrix.rank - 1];
}

/// @pre the interpolator is at this time
template <class S>
void SingularityMonitor<S>::sample_redundant_matrix(RedundantMatrix& matrix, double time) {
  const VectorX sigma = singular_values(matrix);
  const auto rank = static_cast<Eigen::Index>(
      std::count_if(sigma.begin(), sigma.end(), [](double s) { return s > zero_singular_value_tolerance; }));
  if (rank > matrix.rank) {
    const bool had_lower_rank = matrix.rank > 0;
    matrix.rank = rank;
    matrix.minimum_tracker.reset();
    if (had_lower_rank && std::isfinite(decisive_singular_value(matrix, sigma)))
      matrix.rank_loss_times.push_back(start_);
  }
  const auto value_at = [&](double at_time) {
    return interpolate(coarse_history_, at_time) ? decisive_singular_value(matrix, singular_values(matrix)) : INFINITY;
  };
  matrix.minimum_tracker.add_sample({time, decisive_singular_value(matrix, sigma)}, value_at,
                                    [&](const numerics::LocalMinimumTracker::TimedValue& minimum) {
                                      if (minimum.value < zero_singular_value_tolerance)
                                        matrix.rank_loss_times.push_back(minimum.time);
                                    });
}

template <class S>
std::string SingularityMonitor<S>::describe(const RedundantMatrix& matrix) const {
  if (!matrix.is_actuation) return loops_->joint_names(matrix.index);
  const auto coordinate = static_cast<std::size_t>(mechanism_.actuators[matrix.index]);
  return mechanism_.coordinates[coordinate].name;
}

template <class S>
std::vector<std::string> SingularityMonitor<S>::notes() {
  std::vector<std::string> notes;
  if (motion_.is_near())
    notes.push_back(describe_near_singularity(trajectory::SingularityKind::motion, motion_.mobility, motion_.time));
  if (actuation_.is_near())
    notes.push_back(
        describe_near_singularity(trajectory::SingularityKind::actuation, actuation_.mobility, actuation_.time));
  if (redundant_matrices_.empty()) return notes;
  const double end = steps_[2]->time;
  if (has_pending_step_) sample_redundant_matrices();
  for (const RedundantMatrix& matrix : redundant_matrices_) {
    std::vector<double> times = matrix.rank_loss_times;
    if (end > start_ && interpolate(coarse_history_, end) &&
        decisive_singular_value(matrix, singular_values(matrix)) < zero_singular_value_tolerance)
      times.push_back(end);
    if (times.empty()) continue;
    notes.push_back(matrix.is_actuation ? trajectory::describe_redundant_actuator(describe(matrix), times)
                                        : trajectory::describe_change_point(describe(matrix), times));
  }
  return notes;
}

template class SingularityMonitor<Planar>;
template class SingularityMonitor<Spatial>;

namespace {

/// Interpolates y between two samples by the Hermite basis of degree 5.
void interpolate_hermite(const CoordinateSample& a, const CoordinateSample& b, double time, VectorX& y) {
  const double h = b.time - a.time, s = h > 0 ? (time - a.time) / h : 0;
  const double s3 = s * s * s, s4 = s3 * s, s5 = s4 * s;
  const double value_weight = 10 * s3 - 15 * s4 + 6 * s5;
  const double start_rate_weight = s - 6 * s3 + 8 * s4 - 3 * s5, end_rate_weight = -4 * s3 + 7 * s4 - 3 * s5;
  const double start_acceleration_weight = (s * s - 3 * s3 + 3 * s4 - s5) / 2,
               end_acceleration_weight = (s3 - 2 * s4 + s5) / 2;
  y = a.y + value_weight * (b.y - a.y) + h * (start_rate_weight * a.dy + end_rate_weight * b.dy) +
      h * h * (start_acceleration_weight * a.ddy + end_acceleration_weight * b.ddy);
}

}  // namespace

template <class S>
StateInterpolator<S>::StateInterpolator(const Tree<S>& tree, const CompiledTrajectory<S>& plan)
    : tree_(tree), plan_(plan), equations_(tree, plan.drive, plan.has_redundant_closures), state_(tree.nodes.size()) {
  x_.assign(static_cast<std::size_t>(std::max(tree.columns, equations_.rows())), 0);
}

template <class S>
bool StateInterpolator<S>::interpolate(const CoordinateSample& a, const CoordinateSample& b, double time) {
  interpolate_hermite(a, b, time, y_);
  plan_.prescribed_motion->at(time, trajectory::Side::after, sample_);
  constexpr double residual_tolerance = 1e-12,
                   accepted_residual = 1e-7;  // scaled; round-off amplified by a nearby singularity
  constexpr int max_corrections = 4;
  double max_residual = INFINITY;
  for (int k = 0; k <= max_corrections; ++k) {
    compute_poses(tree_, y_.data(), state_);
    equations_.evaluate(state_, y_.data(), sample_, x_.data());
    max_residual = 0;
    for (int r = 0; r < equations_.rows(); ++r) max_residual = std::max(max_residual, std::abs(x_[r]));
    if (max_residual <= residual_tolerance || k == max_corrections) break;
    if (!equations_.factorise(0)) return false;
    equations_.solve(x_.data());
    for (int c = 0; c < tree_.columns; ++c) y_[c] -= x_[c];
  }
  return max_residual <= accepted_residual;
}

template class StateInterpolator<Planar>;
template class StateInterpolator<Spatial>;

}  // namespace balance::kinematics
