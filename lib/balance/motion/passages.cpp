#include "balance/motion/passages.hpp"

#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Pivots from here on are followed: a step may come no nearer than some three times the least distance on its way.
constexpr double interesting = 4 * near_singular;

/// Parts are looked at so often [rad]: no two of their singular configurations are nearer to each other than twice this.
constexpr double look_every = 0.05;

/// Singular values of entries of the order of one that are as good as zero.
constexpr double vanishing = 1e-6;

}  // namespace

template <class S>
Passages<S>::Passages(const Mechanism& mechanism, const Tree<S>& tree, const Plan<S>& plan, const Trail& steps)
    : mechanism_(mechanism), scout_(tree, plan), steps_(steps) {
  if (!plan.redundant) return;  // independent closures stay independent, each loop's too
  loops_.emplace(mechanism, tree);
  for (std::size_t k = 0; k < loops_->loops(); ++k) parts_.push_back({.index = k});
}

template <class S>
void Passages<S>::watch(const Guard<S>& guard) {
  guard_ = &guard;
  std::erase_if(parts_, [](const Part& part) { return part.motors; });
  for (std::size_t k = 0; k < guard.spares(); ++k) parts_.push_back({.index = k, .motors = true});
}

template <class S>
void Passages<S>::push_coarse() {
  std::swap(looked_at_[0], looked_at_[1]);
  std::swap(looked_at_[1], looked_at_[2]);
  looked_at_[2] = *steps_[2];
}

template <class S>
bool Passages<S>::visit(const Trail& trail, double time) {
  if (time == at_) return true;
  const auto& [a, b, c] = trail;
  const bool there = time < b->time ? scout_.visit(*a, *b, time) : scout_.visit(*b, *c, time);
  at_ = there ? time : NAN;
  return there;
}

template <class S>
void Passages<S>::begin(const Equations<S>& equations, double pivot, double hold_pivot) {
  motion_ = actuation_ = {};
  for (Part& part : parts_) part.rank = 0, part.times.clear();
  start_ = steps_[2]->time;
  restart(equations, pivot, hold_pivot);
}

template <class S>
void Passages<S>::restart(const Equations<S>& equations, double pivot, double hold_pivot) {
  motion_.valley.restart();
  actuation_.valley.restart();
  at_ = NAN;
  look_at_distances(equations, pivot, hold_pivot);
  if (parts_.empty()) return;
  for (Part& part : parts_) part.valley.restart();
  looked_at_[2] = *steps_[2];
  look_at_parts();
}

template <class S>
void Passages<S>::see(const Equations<S>& equations, double pivot, double hold_pivot, double way) {
  look_at_distances(equations, pivot, hold_pivot);
  if (parts_.empty()) return;
  turned_ += way;
  pending_ = turned_ < look_every;
  if (!pending_) look_at_parts();
}

template <class S>
void Passages<S>::look_at_distances(const Equations<S>& equations, double pivot, double hold_pivot) {
  look(motion_, equations, pivot, [](const Equations<S>& there) { return there.distance_from_singular(); });
  if (guard_ != nullptr)
    look(actuation_, equations, hold_pivot, [this](const Equations<S>& there) { return guard_->mobility(there); });
}

template <class S>
template <class Mobility>
void Passages<S>::look(NearPass& pass, const Equations<S>& equations, double pivot, const Mobility& mobility) {
  Valley::Place here{steps_[2]->time, INFINITY};
  if (pivot < interesting) {
    here.value = mobility(equations);
    if (here.value < pass.mobility) pass.pivots = pivot / here.value;
    pass.take(here);
  }
  const auto value_at = [&](double time) { return visit(steps_, time) ? mobility(scout_.equations()) : INFINITY; };
  pass.valley.see(here, value_at, [&](const Valley::Place& least) { pass.take(least); });
}

template <class S>
void Passages<S>::look_at_parts() {
  const double now = steps_[2]->time, from = coarse_[2]->time, way = now - from;
  const int pieces = std::max(1, static_cast<int>(std::ceil(turned_ / look_every)));
  push_coarse();
  turned_ = 0;
  pending_ = false;
  for (int piece = 1; piece <= pieces; ++piece) {
    const double time = piece == pieces ? now : from + way * piece / pieces;
    for (Part& part : parts_)
      if (visit(coarse_, time)) look_at(part, time);
  }
}

template <class S>
VectorX Passages<S>::strengths(const Part& part) const {
  return part.motors ? guard_->strengths_without(part.index, scout_.equations())
                     : loops_->strengths(part.index, scout_.state());
}

/// What vanishes where a part loses rank; of motors only where those left determine everything to begin with.
template <class S>
double Passages<S>::weakest(const Part& part, const VectorX& strengths) const {
  if (part.rank == 0 || (part.motors && part.rank < scout_.equations().columns())) return INFINITY;
  return strengths[part.rank - 1];
}

/// The scout is there.
template <class S>
void Passages<S>::look_at(Part& part, double time) {
  const VectorX now = strengths(part);
  const auto rank =
      static_cast<Eigen::Index>(std::count_if(now.begin(), now.end(), [](double s) { return s > vanishing; }));
  if (rank > part.rank) {
    const bool less_before = part.rank > 0;
    part.rank = rank;
    part.valley.restart();
    if (less_before && std::isfinite(weakest(part, now))) part.times.push_back(start_);
  }
  const auto value_at = [&](double when) { return visit(coarse_, when) ? weakest(part, strengths(part)) : INFINITY; };
  part.valley.see({time, weakest(part, now)}, value_at, [&](const Valley::Place& least) {
    if (least.value < vanishing) part.times.push_back(least.time);
  });
}

template <class S>
std::string Passages<S>::name(const Part& part) const {
  if (!part.motors) return loops_->joints(part.index);
  const auto coordinate = static_cast<std::size_t>(mechanism_.actuators[part.index]);
  return mechanism_.coordinates[coordinate].name;
}

template <class S>
std::vector<std::string> Passages<S>::notes() {
  std::vector<std::string> notes;
  if (motion_.is_near()) notes.push_back(passes_near(NearWhat::motion, motion_.mobility, motion_.time));
  if (actuation_.is_near()) notes.push_back(passes_near(NearWhat::actuation, actuation_.mobility, actuation_.time));
  if (parts_.empty()) return notes;
  const double end = steps_[2]->time;
  if (pending_) look_at_parts();
  for (const Part& part : parts_) {
    std::vector<double> times = part.times;
    if (end > start_ && visit(coarse_, end) && weakest(part, strengths(part)) < vanishing) times.push_back(end);
    if (times.empty()) continue;
    notes.push_back(part.motors ? passes_without(name(part), times) : passes_change_point(name(part), times));
  }
  return notes;
}

template class Passages<Planar>;
template class Passages<Spatial>;

}  // namespace balance
