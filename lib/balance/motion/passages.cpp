#include "balance/motion/passages.hpp"

#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Pivots from here on are followed: a step may come no nearer than some three times the least distance on its way.
constexpr double monitor_threshold = 4 * near_singular_pivot_threshold;

/// Parts are looked at so often [rad]: no two of their singular configurations are nearer to each other than twice this.
constexpr double sample_angle = 0.05;

/// Singular values of entries of the order of one that are as good as zero.
constexpr double zero_singular_value_tolerance = 1e-6;

}  // namespace

template <class S>
SingularityMonitor<S>::SingularityMonitor(const Mechanism& mechanism, const Tree<S>& tree,
                                          const CompiledTrajectory<S>& plan, const History& steps)
    : mechanism_(mechanism), interpolator_(tree, plan), steps_(steps) {
  if (!plan.has_redundant_closures) return;  // independent closures stay independent, each loop's too
  loops_.emplace(mechanism, tree);
  for (std::size_t k = 0; k < loops_->loop_count(); ++k) redundant_matrices_.push_back({.index = k});
}

template <class S>
void SingularityMonitor<S>::monitor_actuation(const RegularityMonitor<S>& guard) {
  regularity_monitor_ = &guard;
  std::erase_if(redundant_matrices_, [](const RedundantMatrix& part) { return part.is_actuation; });
  for (std::size_t k = 0; k < guard.redundant_count(); ++k)
    redundant_matrices_.push_back({.index = k, .is_actuation = true});
}

template <class S>
void SingularityMonitor<S>::push_coarse_sample() {
  std::swap(coarse_samples_[0], coarse_samples_[1]);
  std::swap(coarse_samples_[1], coarse_samples_[2]);
  coarse_samples_[2] = *steps_[2];
}

template <class S>
bool SingularityMonitor<S>::interpolate(const History& trail, double time) {
  if (time == interpolated_time_) return true;
  const auto& [a, b, c] = trail;
  const bool there = time < b->time ? interpolator_.interpolate(*a, *b, time) : interpolator_.interpolate(*b, *c, time);
  interpolated_time_ = there ? time : NAN;
  return there;
}

template <class S>
void SingularityMonitor<S>::begin(const KinematicEquations<S>& equations, double pivot, double hold_pivot) {
  motion_ = actuation_ = {};
  for (RedundantMatrix& part : redundant_matrices_) part.rank = 0, part.rank_loss_times.clear();
  start_ = steps_[2]->time;
  restart(equations, pivot, hold_pivot);
}

template <class S>
void SingularityMonitor<S>::restart(const KinematicEquations<S>& equations, double pivot, double hold_pivot) {
  motion_.minimum_tracker.reset();
  actuation_.minimum_tracker.reset();
  interpolated_time_ = NAN;
  sample_distances(equations, pivot, hold_pivot);
  if (redundant_matrices_.empty()) return;
  for (RedundantMatrix& part : redundant_matrices_) part.valley.reset();
  coarse_samples_[2] = *steps_[2];
  sample_redundant_matrices();
}

template <class S>
void SingularityMonitor<S>::sample(const KinematicEquations<S>& equations, double pivot, double hold_pivot,
                                   double way) {
  sample_distances(equations, pivot, hold_pivot);
  if (redundant_matrices_.empty()) return;
  rotation_since_sample_ += way;
  pending_ = rotation_since_sample_ < sample_angle;
  if (!pending_) sample_redundant_matrices();
}

template <class S>
void SingularityMonitor<S>::sample_distances(const KinematicEquations<S>& equations, double pivot, double hold_pivot) {
  sample_distance(motion_, equations, pivot,
                  [](const KinematicEquations<S>& there) { return there.distance_to_singularity(); });
  if (regularity_monitor_ != nullptr)
    sample_distance(actuation_, equations, hold_pivot,
                    [this](const KinematicEquations<S>& there) { return regularity_monitor_->mobility(there); });
}

template <class S>
template <class Mobility>
void SingularityMonitor<S>::sample_distance(NearSingularity& pass, const KinematicEquations<S>& equations, double pivot,
                                            const Mobility& mobility) {
  LocalMinimumTracker::TimedValue here{steps_[2]->time, INFINITY};
  if (pivot < monitor_threshold) {
    here.value = mobility(equations);
    if (here.value < pass.mobility) pass.pivot_per_mobility = pivot / here.value;
    pass.update_minimum(here);
  }
  const auto value_at = [&](double time) {
    return interpolate(steps_, time) ? mobility(interpolator_.equations()) : INFINITY;
  };
  pass.minimum_tracker.add_sample(here, value_at,
                                  [&](const LocalMinimumTracker::TimedValue& least) { pass.update_minimum(least); });
}

template <class S>
void SingularityMonitor<S>::sample_redundant_matrices() {
  const double now = steps_[2]->time, from = coarse_history_[2]->time, way = now - from;
  const int pieces = std::max(1, static_cast<int>(std::ceil(rotation_since_sample_ / sample_angle)));
  push_coarse_sample();
  rotation_since_sample_ = 0;
  pending_ = false;
  for (int piece = 1; piece <= pieces; ++piece) {
    const double time = piece == pieces ? now : from + way * piece / pieces;
    for (RedundantMatrix& part : redundant_matrices_)
      if (interpolate(coarse_history_, time)) sample_redundant_matrix(part, time);
  }
}

template <class S>
VectorX SingularityMonitor<S>::singular_values(const RedundantMatrix& part) const {
  return part.is_actuation ? regularity_monitor_->singular_values_without(part.index, interpolator_.equations())
                           : loops_->singular_values(part.index, interpolator_.state());
}

/// What vanishes where a part loses rank; of motors only where those left determine everything to begin with.
template <class S>
double SingularityMonitor<S>::decisive_singular_value(const RedundantMatrix& part, const VectorX& strengths) const {
  if (part.rank == 0 || (part.is_actuation && part.rank < interpolator_.equations().columns())) return INFINITY;
  return strengths[part.rank - 1];
}

/// The scout is there.
template <class S>
void SingularityMonitor<S>::sample_redundant_matrix(RedundantMatrix& part, double time) {
  const VectorX now = singular_values(part);
  const auto rank = static_cast<Eigen::Index>(
      std::count_if(now.begin(), now.end(), [](double s) { return s > zero_singular_value_tolerance; }));
  if (rank > part.rank) {
    const bool less_before = part.rank > 0;
    part.rank = rank;
    part.valley.reset();
    if (less_before && std::isfinite(decisive_singular_value(part, now))) part.rank_loss_times.push_back(start_);
  }
  const auto value_at = [&](double when) {
    return interpolate(coarse_history_, when) ? decisive_singular_value(part, singular_values(part)) : INFINITY;
  };
  part.valley.add_sample({time, decisive_singular_value(part, now)}, value_at,
                         [&](const LocalMinimumTracker::TimedValue& least) {
                           if (least.value < zero_singular_value_tolerance) part.rank_loss_times.push_back(least.time);
                         });
}

template <class S>
std::string SingularityMonitor<S>::describe(const RedundantMatrix& part) const {
  if (!part.is_actuation) return loops_->joint_names(part.index);
  const auto coordinate = static_cast<std::size_t>(mechanism_.actuators[part.index]);
  return mechanism_.coordinates[coordinate].name;
}

template <class S>
std::vector<std::string> SingularityMonitor<S>::notes() {
  std::vector<std::string> notes;
  if (motion_.is_near())
    notes.push_back(describe_near_singularity(SingularityKind::motion, motion_.mobility, motion_.time));
  if (actuation_.is_near())
    notes.push_back(describe_near_singularity(SingularityKind::actuation, actuation_.mobility, actuation_.time));
  if (redundant_matrices_.empty()) return notes;
  const double end = steps_[2]->time;
  if (pending_) sample_redundant_matrices();
  for (const RedundantMatrix& part : redundant_matrices_) {
    std::vector<double> times = part.rank_loss_times;
    if (end > start_ && interpolate(coarse_history_, end) &&
        decisive_singular_value(part, singular_values(part)) < zero_singular_value_tolerance)
      times.push_back(end);
    if (times.empty()) continue;
    notes.push_back(part.is_actuation ? describe_redundant_actuator(describe(part), times)
                                      : describe_change_point(describe(part), times));
  }
  return notes;
}

template class SingularityMonitor<Planar>;
template class SingularityMonitor<Spatial>;

}  // namespace balance
