/// The plant's dry friction: joints come to rest, stick, turn back and break loose at moments that are found, and between them the
/// motion is smooth.

#include "balance/motion/control/plant_impl.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double rest_rate_fraction =
    1e-10;  // part of the largest rate so far that counts as none where a joint may stick
constexpr double event_time_epsilon = 4e-16;    // of a moment, as part of the time or the step
constexpr double event_margin_epsilon = 1e-13;  // excess that is as good as none
constexpr int max_event_iterations = 80;
constexpr int max_stalled_events = 30;  // without progress, before a step takes no notice of them

}  // namespace

template <class S>
void PlantOf<S>::update_max_rate() {
  if (!loops_.has_dry_friction()) return;
  for (int c = 0; c < loops_.columns(); ++c) max_rate_ = std::max(max_rate_, std::abs(dy_[c]) / loops_.scale()[c]);
}

/// At the present state: which joints stick under these efforts. Those that do hold columns of the tree.
/// @return false at a singularity of the closures
template <class S>
bool PlantOf<S>::update_friction(const VectorX& efforts) {
  if (!loops_.has_dry_friction()) return true;
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  const FrictionChange change =
      loops_.decide_friction(time_, dy_.data(), efforts.data(), rest_rate_fraction * max_rate_);
  if (change != FrictionChange::none) integrator_.restart();
  if (change != FrictionChange::sticking_set) return true;
  last_x_ = x_;
  const bool good = choose_independent_columns();
  pack_state();
  if (loops_.has_shared_stiction() && !has_noted_shared_stiction_) {
    has_noted_shared_stiction_ = true;
    notes_.push_back(
        "dry friction: joints at rest share what holds the mechanism; their friction is one of many that would hold "
        "it");
  }
  return good;
}

template <class S>
double PlantOf<S>::friction_margin(double time) {
  ++cost_.evaluations;
  update_efforts(time);
  return loops_.friction_margin(time, dy_.data(), efforts_.data(), max_rate_);
}

/// To as much after the step's start, x_ being the state there; the integrator begins anew.
template <class S>
bool PlantOf<S>::step_without_error_control(double at) {
  x_ = last_x_;
  const auto slope = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
    derivative(x, dxdt, t);
  };
  integrator_.step_without_error_control(slope, x_, time_, at);
  unpack_state(x_);
  return loops_.solve_dependent(y_.data(), dy_.data());
}

/// Where in a step from last_x_ a joint that slips may have stopped, though it moves on at the end: the part at which its rate is
/// least by the cubic through the rates and accelerations at both ends, if that is below zero. 0 if there is none.
template <class S>
double PlantOf<S>::find_rate_minimum(double step) const {
  double first = 0;
  for (const JointFriction& joint : loops_.frictions()) {
    if (!joint.has_dry_friction() || joint.is_sticking) continue;
    const double unit = joint.slip_direction * joint.ratio();
    const double begin = unit * last_x_[loops_.columns() + joint.column()] * loops_.scale()[joint.column()],
                 gain = unit * dy_[joint.column()] - begin;
    const double falls = unit * step * start_ddy_[joint.column()], rises = unit * step * ddy_[joint.column()];
    if (!(falls < 0 && rises > 0)) continue;
    // begin + falls p + square p² + cube p³
    const double square = 3 * gain - 2 * falls - rises, cube = falls + rises - 2 * gain;
    const double part = -falls / (square + std::sqrt(std::max(0.0, square * square - 3 * falls * cube)));
    if (!(part > 0 && part < 1) || begin + part * (falls + part * (square + part * cube)) >= 0) continue;
    first = first > 0 ? std::min(first, part) : part;
  }
  return first;
}

/// After a good step: is there an event in it?
/// @param high on return the part of the step before which it is @param over the margin there, not negative if there is none
/// @return false if the way there cannot be made
template <class S>
bool PlantOf<S>::has_event_within(double step, double& high, double& over) {
  high = step;
  over = friction_margin(time_ + step);
  if (over < 0) return true;
  const double part = find_rate_minimum(step);
  if (part == 0) return true;
  const std::vector<double> end = x_;
  const VectorX end_ddy = ddy_;
  high = part * step;
  if (!step_without_error_control(high)) return false;
  over = friction_margin(time_ + high);
  if (over < 0) {
    pack_state();
    return true;
  }
  x_ = end;
  ddy_ = end_ddy;
  unpack_state(x_);
  return loops_.solve_dependent(y_.data(), dy_.data());
}

/// After a good step from last_x_ to x_: goes back to the first event on the way, if there is one.
/// @param step that was made @param time at its end; on return of the event
/// @return false if the way there cannot be made
template <class S>
bool PlantOf<S>::locate_event(double step, double& time) {
  is_at_event_ = false;
  if (!loops_.has_dry_friction() || is_ignoring_events_) {
    is_ignoring_events_ = false;
    return true;
  }
  double low = 0, high, over;
  if (!has_event_within(step, high, over)) return false;
  if (over >= 0) return true;
  is_at_event_ = true;
  std::vector<double> there = x_;
  unpack_state(last_x_);
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  double under = std::max(friction_margin(time_), event_margin_epsilon), beyond = over;
  bool above = false, below = false;  // which end the last turn has moved
  for (int turn = 0; turn < max_event_iterations; ++turn) {
    if (high - low <= event_time_epsilon * std::max(std::abs(time_), step) || beyond > -event_margin_epsilon) break;
    // false position (Illinois), with a bisection now and then
    double at = turn % 4 == 3 ? (low + high) / 2 : low + (high - low) * under / (under - over);
    if (!(at > low && at < high)) at = (low + high) / 2;
    if (!(at > low && at < high)) break;
    if (!step_without_error_control(at)) return false;
    const double margin = friction_margin(time_ + at);
    if (margin < 0) {
      high = at, over = beyond = margin;
      if (above) under /= 2;
      pack_state();
      there = x_;
    } else {
      low = at, under = std::max(margin, event_margin_epsilon);
      if (below) over /= 2;
    }
    above = margin < 0, below = !above;
  }
  x_ = there;
  unpack_state(x_);
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  pack_state();
  time = time_ + high;
  return true;
}

/// What sticks and slips from here on.
template <class S>
bool PlantOf<S>::handle_event() {
  ++cost_.events;
  integrator_.restart();
  const bool progress = time_ - event_time_ > 1e-12 * std::max(std::abs(time_), options_.max_step);
  event_time_ = time_;
  stalled_events_ = progress ? 0 : stalled_events_ + 1;
  if (stalled_events_ == max_stalled_events) {
    is_ignoring_events_ = true;
    stalled_events_ = 0;
    step_ = std::max(step_, 1e-6 * options_.max_step);
    const std::string note = "dry friction: sticking and slipping follow each other without end somewhere; steps of " +
                             std::to_string(1e6 * step_) + " us go through it";
    if (std::find(notes_.begin(), notes_.end(), note) == notes_.end() && notes_.size() < 20) notes_.push_back(note);
  }
  update_efforts(time_);
  const bool good = update_friction(efforts_);
  pack_state();
  last_x_ = x_;
  return good;
}

#define BALANCE_INSTANTIATE(S)                                          \
  template void PlantOf<S>::update_max_rate();                          \
  template bool PlantOf<S>::update_friction(const VectorX&);            \
  template double PlantOf<S>::friction_margin(double);                  \
  template bool PlantOf<S>::step_without_error_control(double);         \
  template double PlantOf<S>::find_rate_minimum(double) const;          \
  template bool PlantOf<S>::has_event_within(double, double&, double&); \
  template bool PlantOf<S>::locate_event(double, double&);              \
  template bool PlantOf<S>::handle_event();
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
